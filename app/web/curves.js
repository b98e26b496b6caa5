/** Curves against p on fixed axes, with the current p marked; click or drag one to move p. */

const W = 240;
const H = 104;
const PAD = { left: 34, right: 8, top: 8, bottom: 20 };
const X = (p, [a, b]) => PAD.left + ((p - a) / (b - a)) * (W - PAD.left - PAD.right);
const Y = (v, [lo, hi]) => H - PAD.bottom - ((v - lo) / (hi - lo)) * (H - PAD.top - PAD.bottom);

export const CURVES = [
  { name: "modality_gap", title: "Modality gap", help: "distance between the mean directions of VIS and TAC; the thin line is the raw embedding", good: "lower" },
  { name: "domain_gap", title: "Domain gap", help: "mean distance between the mean directions of two domains; the thin line is the raw embedding", good: "lower" },
  { name: "accuracy", title: "Accuracy", help: "share of pairs predicted right by the whole head; the thin line is guessing", good: "higher" },
  { name: "margin", title: "Cosine margin", help: "mean cosine within classes minus between classes; the thin line is the raw embedding", good: "higher" },
];

/** The values of one curve at one stage, of one domain where named; null where not measured. */
export function values(frames, name, stage, domain = "") {
  const of = name === "accuracy" ? `/${domain || "all"}` : `/${stage}${domain && `/${domain}`}`;
  return frames.meta.curves[name + of] ?? null;
}

/** One axis for a curve at every stage, domain and stop: a flat line stays flat. */
function axis(frames, name) {
  if (name === "accuracy") return [0, 1];
  const all = Object.entries(frames.meta.curves)
    .filter(([key]) => key.startsWith(`${name}/`))
    .flatMap(([, own]) => own.filter(Number.isFinite));
  const top = Math.max(0.1, ...all);
  const low = Math.min(0, ...all);
  const step = 10 ** Math.floor(Math.log10(top)) / 2;
  return [Math.floor(low / step) * step, Math.ceil(top / step - 1e-9) * step];
}

/** A line through the values that exist; a gap starts a new one. */
const path = (frames, own, ys) => own.map((v, i) => (Number.isFinite(v)
  ? `${i && Number.isFinite(own[i - 1]) ? "L" : "M"}${X(frames.orders[i], span(frames)).toFixed(1)} ${Y(v, ys).toFixed(1)}` : "")).join("");
const span = (frames) => [frames.orders[0], frames.orders.at(-1)];

/** What guessing gets. */
const CLOSE = 0.03; // farther from the learned p than this, curves are a what-if

const chance = (frames) => frames.orders.map(() => 1 / frames.classes.length);

export class Curves {
  constructor(box, frames, onOrder) {
    this.frames = frames;
    this.box = box;
    box.innerHTML = CURVES.map((c) => this.chart(c)).join("") + this.note();
    this.charts = [...box.querySelectorAll("figure")];
    for (const chart of this.charts) this.listen(chart.querySelector("svg"), onOrder);
  }

  chart({ name, title, help }) {
    const ys = axis(this.frames, name);
    const [a, b] = span(this.frames);
    const ticks = [ys[0], ys[1]].map((v) =>
      `<text x="${PAD.left - 5}" y="${Y(v, ys) + 4}" text-anchor="end">${+v.toFixed(2)}</text>
       <line class="grid" x1="${PAD.left}" x2="${W - PAD.right}" y1="${Y(v, ys)}" y2="${Y(v, ys)}"/>`);
    const stops = [a, (a + b) / 2, b].map((p, i) =>
      `<text x="${X(p, [a, b])}" y="${H - 6}" text-anchor="${["start", "middle", "end"][i]}">${i === 1 ? "p" : +p.toFixed(2)}</text>`);
    return `<figure data-name="${name}"><figcaption title="${help}"><span>${title} <small class="of"></small></span><output></output></figcaption>
      <svg viewBox="0 0 ${W} ${H}" role="img" aria-label="${title} against p: ${help}">${ticks.join("")}${stops.join("")}
      ${this.band([a, b])}<path class="ghost"/><g class="retrained"></g><path class="own"/><line class="now" y1="${PAD.top}" y2="${H - PAD.bottom}"/><circle class="now" r="4"/></svg></figure>`;
  }

  /** Where the head's weights are at home. */
  band([a, b]) {
    const learned = this.frames.meta.head?.learned_order;
    if (!(learned >= a && learned <= b)) return "";
    const [left, right] = [Math.max(a, learned - CLOSE), Math.min(b, learned + CLOSE)].map((p) => X(p, [a, b]));
    return `<rect class="band" x="${left}" width="${right - left}" y="${PAD.top}" height="${H - PAD.top - PAD.bottom}"/>`;
  }

  /** Why curves are rough away from the learned p. */
  note() {
    const learned = this.frames.meta.head?.learned_order;
    if (!Number.isFinite(learned)) return "";
    return `<details class="what-if"><summary><b aria-hidden="true">?</b> Outside the band: a what-if</summary>
      <p>The head’s weights were learned at p = ${learned.toFixed(3)}. The band is p ± ${CLOSE}; outside it, the curves say how <i>these</i> weights do at a p they were not made for: hence the ups and downs. What heads reach that are trained anew at each p is another question: <code>omnivat ablate --only order</code> answers it<span class="dots"></span>.</p></details>`;
  }

  /** Accuracies of heads trained anew at some p, as dots with error bars: [{order, mean, std}]. */
  retrained(points) {
    const chart = this.charts.find((one) => one.dataset.name === "accuracy");
    const [a, b] = span(this.frames);
    const ys = axis(this.frames, "accuracy");
    const clip = (v) => Y(Math.max(ys[0], Math.min(ys[1], v)), ys).toFixed(1);
    const seen = points.filter(({ order }) => order >= a && order <= b);
    chart.querySelector(".retrained").innerHTML = seen.map(({ order, mean, std }) => {
      const x = X(order, [a, b]).toFixed(1);
      return `<path d="M${x} ${clip(mean - std)}V${clip(mean + std)}"/><circle cx="${x}" cy="${clip(mean)}" r="3"><title>trained at p = ${order}: ${(100 * mean).toFixed(1)} ± ${(100 * std).toFixed(1)} %</title></circle>`;
    }).join("");
    const dots = this.box.querySelector(".dots");
    if (dots) dots.textContent = seen.length ? "; its answers are the dots in the accuracy chart (mean over unseen domains and seeds, ± standard deviation)" : "";
  }

  /** Drag on a chart to move p. */
  listen(svg, onOrder) {
    const moved = (event) => {
      const box = svg.getBoundingClientRect();
      const share = ((event.clientX - box.left) / box.width * W - PAD.left) / (W - PAD.left - PAD.right);
      const [a, b] = span(this.frames);
      onOrder(a + Math.max(0, Math.min(1, share)) * (b - a));
    };
    svg.addEventListener("pointerdown", (event) => {
      svg.setPointerCapture(event.pointerId);
      moved(event);
    });
    svg.addEventListener("pointermove", (event) => event.buttons && moved(event));
  }

  /** Draw the curves of a stage; a thin line keeps the raw embedding's for comparison. */
  show(stage, domain = "") {
    this.own = {};
    for (const chart of this.charts) {
      const { name } = chart.dataset;
      const ys = axis(this.frames, name);
      const only = name === "domain_gap" || name === "margin" ? "" : domain;
      const own = values(this.frames, name, stage, only);
      const raw = name === "accuracy" ? chance(this.frames) : values(this.frames, name, "raw", only);
      chart.querySelector(".of").textContent = only;
      this.own[name] = { own, ys };
      chart.querySelector(".own").setAttribute("d", own ? path(this.frames, own, ys) : "");
      chart.querySelector(".ghost").setAttribute("d", raw && (stage !== "raw" || name === "accuracy") ? path(this.frames, raw, ys) : "");
    }
  }

  /** Mark one stop on every curve and write its value. */
  mark(stop) {
    const x = X(this.frames.orders[stop], span(this.frames));
    for (const chart of this.charts) {
      const { own, ys } = this.own[chart.dataset.name];
      const [line, dot] = chart.querySelectorAll(".now");
      line.setAttribute("x1", x);
      line.setAttribute("x2", x);
      dot.setAttribute("cx", x);
      const known = own && Number.isFinite(own[stop]);
      dot.setAttribute("visibility", known ? "visible" : "hidden");
      if (known) dot.setAttribute("cy", Y(own[stop], ys));
      const text = !known ? "–" : chart.dataset.name === "accuracy" ? `${(100 * own[stop]).toFixed(1)} %` : own[stop].toFixed(3);
      chart.querySelector("output").textContent = text;
    }
  }
}
