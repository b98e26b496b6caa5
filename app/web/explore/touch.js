/** Chapter 1: one press of one object, imaged by every sensor, and what a head reads in each image. */

import { address } from "../shared/api.js";
import { twins as fetchTwins } from "../shared/facts.js";
import { marked } from "./grid.js";
import { $, choice, draw, fill, html, interval, options, percent, scene, send, state } from "./root.js";

/** @type {{key: Reading, label: string, table: Input, title: string}[]} */
export const READINGS = [
  { key: "tac", label: "Touch", table: "touch", title: "Only the sensor changes" },
  { key: "vis", label: "Photo", table: "photo", title: "Only the scene changes" },
  { key: "fused", label: "Both", table: "both", title: "Sensor and scene change" },
];
const LOOKS = [
  { key: "", label: "raw picture" },
  { key: "1", label: "dots filled", title: "Each printed dot gets the colours around it, in training and test" },
  { key: "relief", label: "relief", title: "How the gel bends, in place of its colours, in training and test" },
];
const RELIEF = 2; // of these
const [PHOTO, TOUCH, FILLED] = [0, 1, 2]; // rows of a sheet of pictures
const WORDS = {
  tac: {
    ...{ what: "sensor", on: "on", learned: "touches", tested: "presses" },
    same: html`All pictures show the same press on the same object. Only the <b>sensor</b> differs.`,
  },
  vis: {
    ...{ what: "scene", on: "in", learned: "photos", tested: "objects" },
    same: html`All photos show the same object. Only <b>room and camera</b> differ.`,
  },
  fused: {
    ...{ what: "domain", on: "in", learned: "pairs", tested: "objects" },
    same: html`The object and the press are the same. <b>Sensor and scene</b> differ.`,
  },
};

/** Return the index that a text names in a list; 0 for any other text. @param {string} text @param {unknown[]} list */
const within = (text, list) => (Number(text) in list ? Number(text) : 0);

/** Return the press that is shown: the one in the address, or that which is read best once its dots are filled.
 * @param {Pick<Twins, "shown" | "domains" | "verdicts">} twins @param {Pick<State, "press">} address */
export function pressOf({ shown, domains, verdicts }, { press }) {
  if (press !== "") return within(press, shown);
  const right = shown.map((candidate, i) =>
    candidate.looks_like || candidate.feels_like
      ? -1
      : domains.filter((_, k) => +verdicts.touch[0][1][0][i * domains.length + k] === candidate.class).length,
  );
  return right.indexOf(Math.max(...right));
}

/** Return what the address chooses: indices into the tables of the twins.
 * @param {Twins} twins @param {State} address */
export function chosen(twins, address) {
  const { key, table } = READINGS.find(({ key }) => key === address.reading) ?? READINGS[0];
  return {
    reading: key,
    table,
    press: pressOf(twins, address),
    from: within(address.from, twins.domains),
    look: key === "vis" ? 0 : LOOKS.findIndex(({ key }) => key === address.dots),
    rung: Math.max(0, [0, ...twins.pictures].indexOf(Number(address.known))),
  };
}
/** @typedef {ReturnType<typeof chosen>} Chosen */
/** @typedef {ReturnType<typeof read>} Figures */

/** Return the figures at what is chosen: `away` and each target's [share, low, high], and the class read in each image.
 * @param {Twins} twins @param {Chosen} at */
function read({ away, accuracy, verdicts, domains, shown, learned }, { table, from, look, rung, press }) {
  const count = domains.length;
  return {
    away: away[table][from][look][rung],
    shares: accuracy[table][from][look][rung],
    said: Array.from({ length: count }, (_, i) => Number(verdicts[table][from][look][rung][press * count + i])),
    truth: shown[press].class,
    chance: 1 / learned[from].length,
  };
}

/** Fetch the twins once and draw the chapter; later calls only draw. */
export async function open() {
  const twins = await fetchTwins();
  send("arrived", { twins });
  show();
}

/** Draw the chapter; the legend is about the domain that is pointed at. */
export function show(pointed = -1) {
  const at = chosen(scene.twins, state);
  const figures = read(scene.twins, at);
  showChoices(at);
  fill($(".twin-pictures"), pictures(at, figures, pointed));
  showFigures(at, figures);
}

/** Show the choices of press, look, pictures and reading. @param {Chosen} at */
function showChoices(at) {
  const { domains, shown, pictures, classes } = scene.twins;
  const presses = shown.map((press, i) => ({
    key: String(i),
    title: `${classes[press.class]}, press ${i + 1}`,
    label: html`<span style="${background("presses.webp", i, shown.length)}"></span>`,
  }));
  const known = [0, ...pictures].map((n) => ({ key: String(n), label: n ? String(n) : "none" }));
  choice(".presses", "press", presses, String(at.press));
  choice(".touch .dots", "dots", LOOKS);
  fill($("#ov-known"), html`Unlabelled pictures of the new ${WORDS[at.reading].what}`);
  choice(".known", "known", known);
  choice(".given", "reading", READINGS);
  draw($(".touch .from"), options(domains.map(({ sensor }, i) => [i, sensor])));
  $(".touch .from").value = String(at.from);
  $(".touch .dots").hidden = at.reading === "vis";
}

/** Return a tile of a sheet of pictures, as a style.
 * @param {string} sheet @param {number} column @param {number} columns */
const background = (sheet, column, columns, row = 0, rows = 1) =>
  `background:url('${address(`twins/${sheet}`)}') ${(100 * column) / (columns - 1 || 1)}% ` +
  `${(100 * row) / (rows - 1 || 1)}%/${100 * columns}% ${100 * rows}%`;

const beside = (/** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ chance) =>
  `${interval(low, high)}; chance: ${percent(chance)}`;

/** Return the object, what is read in its picture by each domain, and what the domain is that is pointed at.
 * @param {Chosen} at @param {Figures} figures @param {number} pointed */
function pictures(at, { said, truth, shares, chance }, pointed) {
  const { domains, classes, shown } = scene.twins;
  const { sheet, looks_like: looks } = shown[at.press];
  const photo = at.reading === "vis";
  const picture = (/** @type {number} */ row, /** @type {number} */ column) =>
    background(sheet, column, domains.length, row, 3);
  const bent = (/** @type {number} */ column) => background(sheet.replace(".", ".relief."), column, domains.length);
  const cards = domains.map(({ sensor }, i) => {
    const right = said[i] === truth;
    const [share, low, high] = shares[i];
    return html`<figure class="twin ${i === at.from && "home"} ${right && "is-right"}" tabindex="0" data-domain="${i}">
      <span class="tile" role="img" aria-label="This press by ${sensor}${at.look === RELIEF && ", as its relief"},
        predicted as ${classes[said[i]]}"><i style="${picture(photo ? PHOTO : TOUCH, i)}"></i>
        <i class="filled" style="${picture(FILLED, i)};opacity:${Math.min(at.look, 1)}"></i>
        ${at.look === RELIEF && html`<i class="relief" style="${bent(i)}"></i>`}
        ${at.reading === "fused" && html`<i class="inset" style="${picture(PHOTO, i)}"></i>`}</span>
      <b class="said">${marked(right, classes[said[i]])}</b><figcaption>${sensor}
        ${i === at.from && html` <small>(training ${WORDS[at.reading].what})</small>`}</figcaption>
      <span class="share" title="${beside(low, high, chance)}"><span class="scale"
        style="--share:${share};--low:${low};--high:${high};--chance:${chance}"><i class="fill"></i>
        <i class="range"></i></span><output>${percent(share)}</output></span></figure>`;
  });
  const { about, scene: place } = domains[pointed] ?? {};
  const seen = `Photographed ${place}.`;
  const legend = about
    ? { tac: about, vis: seen, fused: `${about} ${seen}` }[at.reading]
    : html`<span class="bar-key">Short bar: 95\u00a0% interval. Thin line: chance.</span>`; // bars need a wide page
  return html`<figure class="object"><span class="tile" role="img" aria-label="the object, ${classes[truth]}">
    <i style="${picture(photo ? TOUCH : PHOTO, at.from)}"></i></span><figcaption><b>${classes[truth]}</b>
    ${looks && html`<br><small>looks like ${looks}</small>`}</figcaption></figure>${cards}
    <p class="legend" aria-live="polite">${legend}</p>`;
}

/** Show the share read right on another sensor, and where it comes from. @param {Chosen} at @param {Figures} figures */
function showFigures(at, { away: [share, low, high], shares, chance }) {
  const { domains, head, known, lamps, presses } = scene.twins;
  const { what, on, same, learned, tested } = WORDS[at.reading];
  const lit = at.look === RELIEF;
  const n = Math.min([0, ...known[at.table]][at.rung], lit ? lamps : Infinity); // of some there are no more
  fill($(".touch .same"), same);
  fill(
    $(".touch .figure"),
    html`<b class="large" title="${beside(low, high, chance)}">
      ${percent(share)}</b> correct ${on} another ${what}, <b>${percent(shares[at.from][0])}</b> ${on} the
      training ${what}.`,
  );
  const looks = [
    "",
    "Each printed dot gets the colours around it, in training and test.",
    "Grey shows how the gel bends: dark at edges, light in hollows.",
  ];
  const few = n
    ? html` ${n} pictures of the new ${what} provide ${lit && "its lamps and "}the mean and spread of each feature.`
    : lit && " Nothing is known of the new sensor: each picture alone gives its relief.";
  fill($(".touch .remark"), html`${looks[at.look]}${few}`);
  $(".from-where .head").title = head.replace("{source}", domains[at.from].name);
  const given = n ? `${n} unlabelled pictures` : "nothing";
  const about = `${learned} and tested on ${presses[at.table][at.from]} ${tested}`;
  $(".from-where .what").textContent = `${about}. The model was given ${given} from the new ${what}.`;
}
