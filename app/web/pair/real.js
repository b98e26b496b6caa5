/** Real pairs of others, which the owner of the server has fetched: with their terms, and read like dropped pictures. */

import { address, attempt, get, json } from "../shared/api.js";
import { held } from "../shared/held.js";
import { IMAGES } from "../shared/images.js";
import { change } from "../shared/store.js";
import { each, escaped } from "../shared/text.js";
import { onClick, View } from "../shared/view.js";
import { sent, upload } from "./own-pictures.js";

const COMMAND =
  "None here. Run <code>python -m omnivat fetch touch-and-go</code> in the folder of the server, and reload the page.";

/** Title without its subtitle. */
const short = ({ title }) => title.split(/[:,]/)[0];
const licence = ({ licence: named, terms }) => named.split(", ")[0] || terms || "no terms stated";

/** What stands with a picture: its authors in short, its terms, what was changed. */
function credit(set) {
  const [first, ...others] = set.authors.split(", ");
  const authors = others.length ? `${first} and ${others.length} others` : first;
  const changed = set.changes === "none" ? "" : `; changed: ${set.changes}`;
  return `by ${authors}, ${licence(set)}${changed}`;
}

export class RealPairs extends View {
  /** take: the choice of what to take of a pair; onBusy(±1) around an upload. */
  constructor(box, take, { onBusy, onProblem }) {
    super(box);
    this.take = take;
    this.onBusy = onBusy;
    this.onProblem = onProblem;
    this.sets = [];
    onClick(box, { "[data-pair]": (button) => this.open(button, this.sets[button.dataset.set], +button.dataset.pair) });
    if (!held) attempt(async () => this.show(await json("real")), onProblem);
  }

  show({ local, sets, left_out: leftOut }) {
    this.sets = sets;
    const lines = leftOut.length || sets.length || !local ? each(leftOut, (one) => hint(escaped(one))) : hint(COMMAND);
    this.box.hidden = !sets.length && !lines;
    this.box.innerHTML = `<h3>Real</h3>${each(sets.keys(), (k) => setHtml(sets[k], k))}${lines}`;
  }

  /** Read a pair as if its pictures had been dropped; a later click goes first. */
  async open(button, set, number) {
    const { pictures, class: name } = set.pairs[number];
    const { value } = this.take;
    const wanted = IMAGES.filter((one) => pictures[one] && (value === "both" || value === one));
    if (!wanted.length) return this.onProblem(`${short(set)} has touches alone.`);
    this.opened = button;
    this.onBusy(1);
    button.setAttribute("aria-busy", "true");
    await attempt(async () => {
      /** @type {Pair} */
      const refs = value === "both" ? { vis: null, tac: null } : {};
      for (const one of wanted) {
        const content = await (await get(`real/${pictures[one]}`)).blob();
        refs[one] = await upload(new File([content], `${name}, ${short(set)}`));
        sent.get(refs[one]).credit = credit(set);
      }
      if (this.opened !== button) return;
      button.dataset.ref = refs.tac ?? refs.vis;
      change(refs);
      this.box.closest(".pair").querySelector(".slots").scrollIntoView({ block: "nearest" }); // the result is above
    }, this.onProblem);
    button.removeAttribute("aria-busy");
    this.onBusy(-1);
  }

  mark(refs) {
    for (const button of this.box.querySelectorAll("button"))
      button.setAttribute("aria-pressed", String(refs.includes(button.dataset.ref)));
  }
}

const hint = (html) => `<p class="hint">${html}</p>`;

function setHtml(set, k) {
  const [name, link] = set.licence.split(", ");
  const terms = link
    ? `<a href="${escaped(link)}" target="_blank" rel="noreferrer">${escaped(name)}</a>`
    : `Terms: ${escaped(`${set.terms || "none stated"} (${set.terms_from})`)}`;
  const changes = set.changes === "none" ? "" : ` Changed: ${escaped(set.changes)}.`;
  const count = set.pairs.length < set.count ? ` ${set.pairs.length} of ${set.count.toLocaleString()} pairs.` : "";
  return `<figure><figcaption class="hint"><b>${escaped(set.title)}</b>, by ${escaped(set.authors)}. ${terms}.${changes}${count}</figcaption>
    <div class="gallery" tabindex="0" role="group" aria-label="Pairs of ${escaped(short(set))} to pick">${each(set.pairs.keys(), (pair) => pairHtml(set, k, pair))}</div></figure>`;
}

function pairHtml(set, k, pair) {
  const { pictures, class: name } = set.pairs[pair];
  const images = IMAGES.filter((one) => pictures[one]).map(
    (one) => `<img loading="lazy" alt="" src="${escaped(address(`real/${pictures[one]}`))}">`,
  );
  const label = escaped(`${name}, ${short(set)}`);
  return `<button type="button" data-set="${k}" data-pair="${pair}" title="${label}, ${escaped(credit(set))}" aria-label="${label}"><span>${images.join("")}</span><small>${escaped(name)}</small></button>`;
}
