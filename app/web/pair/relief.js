/** The relief of the open touch, to turn: by the lamps of the visitor's profile, or from touches of its sensor that
 * this browser has. */

import { address, attempt, bytesOf, made, once, Refusal } from "../shared/api.js";
import { held } from "../shared/held.js";
import { isDark, onTheme } from "../shared/palette.js";
import { save } from "../shared/save.js";
import { bytesOf as decoded } from "../shared/text.js";
import { View } from "../shared/view.js";
import { describe, partsOf } from "./own-pictures.js";
import { draw, html, LARGEST, plural } from "./parts.js";

const FEWEST = 5; // touches that give good lamps
const MOST = 20;
/** @type {Record<string, [number, number]>} */
const TURNS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const STEP = 0.15; // radians
const STEEPEST = 1.5;

/** Touches of the same sensor as the open one, which is the first: of its domain's examples, or the visitor's own of
 * this visit. @param {PairTab} tab @returns {Ref[]} */
function touchesOf({ tac, examples, touches, sent }) {
  if (!tac || tac.startsWith("row:")) return [];
  const domain = examples.find(({ name }) => tac === `example:${name}`)?.domain;
  const others = domain
    ? examples.filter((one) => one.domain === domain).map(({ name }) => /** @type {Ref} */ (`example:${name}`))
    : touches.filter((ref) => sent[ref]?.credit === sent[tac]?.credit);
  return [...new Set([tac, ...others])].slice(0, MOST);
}

/** The profile of the sensor that made the open touch, which may hold its lamps. @param {PairTab} tab */
const profileOf = ({ tac, profile }) => (tac?.startsWith("image:") ? profile : "");

/** Why there is no relief; "" if there may be one. @param {PairTab} tab */
export function lacking(tab) {
  if (!tab.tac) return "Choose a touch first.";
  if (tab.tac.startsWith("row:"))
    return "Of this pair the server keeps features only. Open an example or a touch of your own to see its relief.";
  const more = profileOf(tab) ? 0 : FEWEST - touchesOf(tab).length;
  const own = tab.tac.startsWith("image:");
  return more > 0
    ? `${plural(more, "more picture")} of ${own ? "your" : "this"} sensor would give its lamps, and with them the ` +
        "relief. Labels are not needed."
    : "";
}

export class Relief extends View {
  /** @param {HTMLElement} root @param {() => PairTab} tab */
  constructor(root, tab) {
    super(root);
    this.tab = tab;
    this.shown = "";
    root.hidden = Boolean(held); // the lamps are computed by the server
    root.addEventListener("toggle", () => this.show());
    onTheme(() => this.show());
    this.$(".surface").onkeydown = (/** @type {KeyboardEvent} */ event) => this.turn(event);
    this.$(".row").onclick = (/** @type {Found} */ { target }) => {
      const { as } = target.dataset;
      if (as) attempt(() => this.save(as), this.$(".hint"));
    };
  }

  /** Draw the open touch, if the panel is open and something changed. */
  async show() {
    const tab = this.tab();
    const refs = touchesOf(tab);
    const key = `${refs} ${profileOf(tab)} ${lacking(tab)} ${isDark()}`;
    if (!this.box.open || key === this.shown) return;
    this.shown = key;
    const why = lacking(tab);
    this.say(why || "Computing the lamps…");
    this.$(".surface").replaceChildren(); // Plotly drew there, of which draw knows nothing
    draw(this.$(".row"), html``);
    if (why) return;
    await attempt(async () => {
      const [made] = await Promise.all([this.made("figures"), plotly()]);
      const { figures, caption } = JSON.parse(await made.text());
      if (key !== this.shown) return;
      const boxes = figures.map(() => document.createElement("div"));
      this.$(".surface").replaceChildren(...boxes);
      const config = { displaylogo: false, displayModeBar: false, responsive: true };
      for (const [k, { data, layout }] of figures.entries())
        await window.Plotly.newPlot(boxes[k], data, { ...layout, meta: undefined, autosize: true }, config);
      const words = { png: "PNG picture", npy: "NPY: slopes, heights", ply: "PLY surface" };
      draw(
        this.$(".row"),
        html`${Object.entries(words).map(
          ([as, label]) => html`<button type="button"
          data-as="${as}">${label}</button>`,
        )}`,
      );
      this.say(`${caption} Drag the surface, or use the arrow keys, to turn it.`);
    }, this.$(".hint"));
  }

  /** @param {string} words */
  say(words) {
    this.$(".hint").textContent = words;
  }

  /** What the server makes of the touches. @param {string} as */
  async made(as) {
    const tab = this.tab();
    const blobs = [];
    let size = 0;
    for (const ref of touchesOf(tab)) {
      const blob = await bytesOf(ref, "tac");
      if (!blob && ref === tab.tac) throw new Refusal("The server keeps no images. Choose this file again.");
      size += blob?.size ?? 0;
      if (blob && size <= LARGEST) blobs.push(blob);
    }
    const name = describe(tab, /** @type {Ref} */ (tab.tac)).text;
    const question = { as, theme: isDark() ? "dark" : "light", name, profile: profileOf(tab) };
    return made("relief", question, blobs);
  }

  /** @param {string} as */
  async save(as) {
    const name = `relief-${partsOf(/** @type {Ref} */ (this.tab().tac))[1]
      .replaceAll("/", "-")
      .slice(-40)}`;
    if (as !== "png") return save(`${name}.${as}`, await this.made(as));
    const picture = await window.Plotly.toImage(this.$(".surface > div"), { format: "png", scale: 2 });
    save(`${name}.png`, new Blob([decoded(picture.split(",")[1])], { type: "image/png" }));
  }

  /** @param {KeyboardEvent} event */
  turn(event) {
    const [across, up] = TURNS[event.key] ?? [];
    if (across === undefined || up === undefined || !this.$(".surface > div")) return;
    event.preventDefault();
    const plot = this.$(".surface > div");
    if (!plot._fullLayout) return;
    const { x, y, z } = plot._fullLayout.scene.camera.eye;
    const [far, angle] = [Math.hypot(x, y, z), Math.atan2(y, x) + across * STEP];
    const height = Math.max(-STEEPEST, Math.min(STEEPEST, Math.asin(z / far) + up * STEP));
    const flat = far * Math.cos(height);
    const eye = { x: flat * Math.cos(angle), y: flat * Math.sin(angle), z: far * Math.sin(height) };
    window.Plotly.relayout(plot, { "scene.camera.eye": eye });
  }
}

/** Plotly, loaded once. */
const plotly = () =>
  once("plotly", async () => {
    if (window.Plotly) return;
    const script = document.createElement("script");
    script.src = address("plotly.js");
    await new Promise((done, failed) => {
      script.onload = done;
      script.onerror = () => failed(new Refusal("The script that draws the relief did not arrive. Try again."));
      document.head.append(script);
    });
  });
