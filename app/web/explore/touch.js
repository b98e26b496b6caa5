/** Chapter 1: one press of one object, imaged by every sensor, and what a head reads in each image. */

import { address } from "../shared/api.js";
import { twins } from "../shared/facts.js";
import { radios } from "../shared/radios.js";
import { change, state } from "../shared/store.js";
import { each, escaped, fill, options, percent } from "../shared/text.js";
import { View } from "../shared/view.js";

export const READINGS = [
  { key: "tac", label: "Touch", table: "touch", title: "Only the sensor changes" },
  { key: "vis", label: "Photo", table: "photo", title: "Only the scene changes" },
  { key: "fused", label: "Both", table: "both", title: "Sensor and scene change" },
];
const DOTS = [
  { key: "", label: "as it comes" },
  { key: "1", label: "dots filled", title: "Each dot takes the colours around it, in training too" },
];
const [PHOTO, TOUCH, FILLED] = [0, 1, 2]; // rows of a sheet of pictures
const WORDS = {
  tac: { one: "sensor", same: "Same object, same press; only the <b>sensor</b> changed.", learned: "touches" },
  vis: { one: "scene", same: "Same object; only <b>room and camera</b> changed.", learned: "photos" },
  fused: { one: "domain", same: "Same object, same press; <b>sensor and scene</b> changed.", learned: "pairs" },
};

const within = (text, count) => (Number(text) >= 0 && Number(text) < count ? Math.floor(Number(text)) : 0);

/** The press that is shown: the one in the address, or that which is read best once its dots are filled. */
export function pressOf({ shown, domains, verdicts }) {
  if (state.press !== "") return within(state.press, shown.length);
  const right = shown.map((one, i) =>
    one.looks_like || one.feels_like
      ? -1
      : domains.filter((_, k) => +verdicts.touch[0][1][0][i * domains.length + k] === one.class).length,
  );
  return right.indexOf(Math.max(...right));
}

/** What the address chooses: indices into the tables of the twins. */
export function chosen(twins) {
  const reading = READINGS.find(({ key }) => key === state.reading) ?? READINGS[0];
  return {
    reading: reading.key,
    table: reading.table,
    press: pressOf(twins),
    from: within(state.from, twins.domains.length),
    dots: Number(state.dots === "1" && reading.key !== "vis"),
    rung: Math.max(0, [0, ...twins.pictures].indexOf(Number(state.known))),
  };
}

/** The figures at what is chosen: `away` and each target's [share, low, high], and the class read in each image. */
export function read(twins, at) {
  const of = (table) => twins[table][at.table][at.from][at.dots][at.rung];
  const count = twins.domains.length;
  const said = of("verdicts").slice(at.press * count, (at.press + 1) * count);
  return {
    away: of("away"),
    shares: of("accuracy"),
    said: [...said].map(Number),
    truth: twins.shown[at.press].class,
    chance: 1 / twins.learned[at.from].length,
  };
}

export class OneTouch extends View {
  /** @type {any} as `examples/twins.json` */
  twins = null;
  /** @type {(() => void)[]} */
  marks = []; // show what is chosen in each group of buttons
  /** @type {any[]} */
  cards = [];

  /** Fetch the twins once and draw the chapter; later calls only draw. */
  async open() {
    this.twins ??= await twins();
    if (!this.cards.length) this.build();
    this.show();
    document.dispatchEvent(new CustomEvent("omnivat:simulated", { detail: this.twins.simulated }));
  }

  build() {
    const { domains, shown, pictures, classes } = this.twins;
    const presses = shown.map((one, i) => ({ key: String(i), label: `${classes[one.class]}, press ${i + 1}` }));
    const known = [0, ...pictures].map((n) => ({ key: String(n), label: n ? String(n) : "none" }));
    const group = (selector, list, name, now = () => state[name]) =>
      radios(this.$(selector), list, now, (key) => change({ [name]: key }));
    this.marks = [
      group(".presses", presses, "press", () => String(pressOf(this.twins))),
      group(".dots", DOTS, "dots"),
      group(".known", known, "known"),
      group(".given", READINGS, "reading"),
    ];
    const strip = address("twins/presses.webp");
    [...this.$(".presses").children].forEach((button, i) => {
      const at = (100 * i) / (shown.length - 1 || 1);
      button.title = button.textContent;
      button.setAttribute("aria-label", button.textContent);
      button.innerHTML = `<span style="background:url('${strip}') ${at}% 0/${100 * shown.length}% 100%"></span>`;
    });
    this.$(".from").innerHTML = options(domains.map(({ sensor }, i) => [String(i), sensor]));
    this.$(".from").onchange = ({ target }) => change({ from: target.value });
    this.$(".twin-pictures").innerHTML =
      `<figure class="object"><span class="tile" role="img"><i></i></span><figcaption></figcaption></figure>${each(
        domains,
        (
          { sensor },
          i,
        ) => `<figure class="twin" tabindex="0" data-domain="${i}"><span class="tile" role="img"><i></i><i class="filled"></i><i class="inset"></i></span>
        <b class="said"></b><figcaption>${escaped(sensor)}</figcaption><span class="share"><span class="scale"><i class="fill"></i><i class="range"></i></span><output></output></span></figure>`,
      )}<p class="legend" aria-live="polite"></p>`;
    this.cards = [...this.box.querySelectorAll(".twin")];
    for (const card of this.cards) {
      const tell = () => this.tell(+card.dataset.domain);
      card.onpointerenter = card.onfocus = tell;
      card.onpointerleave = card.onblur = () => this.tell(-1);
    }
  }

  /** What a domain's sensor or scene is; without one, how to read the bars. */
  tell(domain) {
    const { about, scene } = this.twins.domains[domain] ?? {};
    const at = chosen(this.twins);
    const seen = `Photographed ${scene}.`;
    const words = { tac: about, vis: seen, fused: `${about} ${seen}` }[at.reading];
    const bars = "95\u00a0% intervals; line: guessing.";
    fill(this.$(".legend"), domain < 0 ? bars : escaped(words));
  }

  show() {
    const at = chosen(this.twins);
    const figures = read(this.twins, at);
    for (const mark of this.marks) mark();
    this.$(".from").value = String(at.from);
    this.$(".dots").hidden = at.reading === "vis";
    this.showPictures(at, figures);
    this.showFigures(at, figures);
    this.tell(-1);
  }

  showPictures(at, { said, truth, shares, chance }) {
    const { domains, classes, shown } = this.twins;
    const url = address(`twins/${shown[at.press].sheet}`);
    const place = (tile, row, column) => {
      tile.style.background = `url("${url}") ${(100 * column) / (domains.length - 1)}% ${50 * row}%/${100 * domains.length}% 300%`;
    };
    const object = this.$(".object");
    place(object.querySelector("i"), at.reading === "vis" ? TOUCH : PHOTO, at.from);
    const { looks_like: looks } = shown[at.press];
    const like = looks ? `<br><small>looks like ${escaped(looks)}</small>` : "";
    fill(object.querySelector("figcaption"), `<b>${escaped(classes[truth])}</b>${like}`);
    object.querySelector(".tile").setAttribute("aria-label", `the object, ${classes[truth]}`);
    this.cards.forEach((card, i) => {
      const right = said[i] === truth;
      const [front, filled, inset] = card.querySelectorAll(".tile i");
      place(front, at.reading === "vis" ? PHOTO : TOUCH, i);
      place(filled, FILLED, i);
      place(inset, PHOTO, i);
      filled.style.opacity = at.dots;
      inset.hidden = at.reading !== "fused";
      card.classList.toggle("home", i === at.from);
      card.classList.toggle("is-right", right);
      card
        .querySelector(".tile")
        .setAttribute("aria-label", `${domains[i].sensor} of this press, read as ${classes[said[i]]}`);
      fill(card.querySelector(".said"), `${right ? "✓" : "✗"}\u00a0${escaped(classes[said[i]])}`);
      const name = `${escaped(domains[i].sensor)}${i === at.from ? " <small>learned here</small>" : ""}`;
      fill(card.querySelector("figcaption"), name);
      this.showShare(card, shares[i], chance);
    });
  }

  showShare(card, [share, low, high], chance) {
    const scale = card.querySelector(".scale");
    for (const [name, value] of Object.entries({ share, low, high, chance }))
      scale.style.setProperty(`--${name}`, value);
    scale.parentElement.title = `95 % interval ${percent(low)} to ${percent(high)}; guessing: ${percent(chance)}`;
    fill(card.querySelector("output"), percent(share));
  }

  showFigures(at, { away: [share, low, high], shares, chance }) {
    const { domains, head, known, presses } = this.twins;
    const { one, same, learned } = WORDS[at.reading];
    const source = domains[at.from];
    const n = [0, ...known[at.table]][at.rung]; // of some there are no more
    fill(this.$(".same"), same);
    fill(
      this.$(".figure"),
      `<b class="large" title="95 % interval ${percent(low)} to ${percent(high)}; guessing: ${percent(chance)}">${percent(share)}</b> right on another ${one}, <b>${percent(shares[at.from][0])}</b> on the first.`,
    );
    const dots = "Dots are filled with the colours around them, in training too: nothing is known of the new sensor.";
    const few = `${n} pictures of the new ${one} give each feature’s mean and spread. No label is used.`;
    fill(this.$(".remark"), [at.dots && dots, n && few].filter(Boolean).join(" "));
    this.$(".from-where .head").title = head.replace("{source}", source.name);
    this.$(".from-where .what").textContent =
      `${learned}; ${presses[at.table][at.from]} twins; known: ${n ? `${n} other pictures` : "nothing"}.`;
  }
}
