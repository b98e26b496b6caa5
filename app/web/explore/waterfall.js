/** The anatomy of the failure: accuracy at home, away, and back up for each thing that is known. */

import { attempt } from "../shared/api.js";
import { ladder } from "../shared/facts.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { each, escaped, fill, options, percent } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";

const STATES = [
  { key: "0", label: "As they come" },
  { key: "1", label: "Each domain centred", title: "The mean of its own touches is taken from each domain" },
];
const SHOWN = ["home", "none", "n5", "n20", "all", "k3", "m2"]; // of the ladder
const WORDS = {
  home: "at home",
  none: "a new sensor",
  n5: "+ 5 pictures, no labels",
  n20: "+ 20 pictures",
  all: "+ all pictures",
  k3: "+ 3 labels a class",
  m2: "two source sensors",
};
const plain = (name) => name.replace(/-sim$/, "");

const methodOf = (known = "") => /\(([^)]*)\)$/.exec(known)?.[1] ?? "";

/** What a bar sets the map to: centred domains if pictures of the new sensor are known. */
const stateOf = (rung) => (/^(n|all)/.test(rung) ? "1" : "0");

/** The first two rungs, from what is known of the loaded head. */
export function firstRungs({ facts: { unseen } }) {
  const home = unseen?.domains.find(({ is_source }) => is_source)?.["answers/fused"];
  const away = unseen?.unseen["answers/fused"];
  const rung = (name, own) =>
    own && { rung: name, accuracy: own.share, low: own.low, high: own.high, from: "this head" };
  return [rung("home", home), rung("none", away)].filter(Boolean);
}

/** A change in points, with its sign. */
export const signed = (points) => `${points < 0 ? "−" : "+"}${Math.abs(points).toFixed(1)}`;

/** {points, sure}: what a rung changes in the accuracy away from home, and whether the two intervals are
 * apart; null for home, away itself, and rungs of another head, whose accuracy as they come is another. */
export function changeOf({ rung, accuracy, low, high, from, known = "" }, away) {
  const same = away && away.from === from && methodOf(known) === methodOf(away.known);
  if (!same || rung === "home" || rung === "none") return null;
  return { points: 100 * (accuracy - away.accuracy), sure: low > away.high || high < away.low };
}

export class Waterfall extends View {
  constructor(box, choice, scene) {
    super(box);
    this.choice = choice;
    this.scene = scene;
    this.source = "";
    this.at = ""; // the bar that was chosen
    onClick(box, {
      "[data-rung]": ({ dataset }) => {
        change({ rung: stateOf((this.at = dataset.rung)) });
        this.show();
      },
    });
    box.onchange = (event) => this.fetch((this.source = event.target.value));
  }

  /** Fetch the ladder of a source; the head's own comes first. */
  async fetch(source = "") {
    const { set } = this.scene;
    this.wanted = `${set} ${source}`;
    return attempt(
      async () => {
        // the first two bars stay
        const found = await ladder(set, source);
        if (this.wanted !== `${set} ${source}` || this.scene.set !== set) return;
        this.found = { set, ...found };
        this.show();
      },
      () => {},
    );
  }

  /** Draw the bars {rung, known, accuracy, low, high, from}. */
  show() {
    const { scene } = this;
    const centred = scene.frames.kindOfStops === "centred";
    const alone = scene.own.domain.every((one) => one === scene.own.domain[0]);
    this.choice.hidden = !centred || alone;
    this.box.hidden = scene.own.headless || alone;
    if (this.box.hidden) return this.mark?.();
    if (centred && !this.choice.firstChild)
      this.mark = radios(
        this.choice,
        STATES,
        () => state.rung,
        (rung) => change({ rung }),
      );
    this.mark?.();
    const known = this.found?.set === scene.set ? this.found : null;
    if (!known && this.asked !== scene.set) this.fetch((this.source = ""));
    this.asked = scene.set;
    const all = known?.rungs.length ? known.rungs : firstRungs(scene);
    const bars = all.filter(({ rung }) => SHOWN.includes(rung));
    const away = bars.find(({ rung }) => rung === "none");
    const other = bars.some((one) => one.from === "records") && bars.some((one) => one.from !== "records");
    const html = each(bars, (one) => this.bar(one, away, known?.kept));
    const doubt = bars.some((one) => changeOf(one, away)?.sure === false);
    const notes = [
      known?.kept && "Striped: kept in a file, not measured now.",
      other && "Pale: other heads, recorded.",
      doubt && "Grey: intervals overlap.",
    ];
    const note = `<p class="hint">${notes.filter(Boolean).join(" ")}</p>`;
    const sources = known?.sources ?? [];
    const list = options(
      sources.map((name) => [name, plain(name)]),
      this.source || sources[0],
    );
    const choice = sources.length > 1 ? `<label class="hint">Learned from <select>${list}</select></label>` : "";
    fill(this.box, choice + html + note);
  }

  bar({ rung, known, accuracy, low, high, from }, away, kept) {
    const more = changeOf({ rung, known, accuracy, low, high, from }, away);
    const up = more?.sure && more.points > 0;
    const gain = more
      ? ` <small${more.sure ? ' class="sure"' : ' title="The intervals overlap, so the change is not sure."'}>${signed(more.points)}</small>`
      : "";
    const on = this.at ? this.at === rung : rung === "none";
    return `<button type="button" class="fall${from === "records" ? " recorded" : kept ? " kept" : ""}" data-rung="${rung}" aria-pressed="${on}" title="${escaped(known ?? "")}${kept && from !== "records" ? ", from the file next to the set" : ""}: 95 % interval ${percent(low)} to ${percent(high)}" style="--share:${accuracy};--from:${up ? away.accuracy : 0};--low:${low};--high:${high}"><span>${escaped(WORDS[rung] ?? known)}</span><span class="bar"><i class="range"></i></span><b>${percent(accuracy)}${gain}</b></button>`;
  }
}
