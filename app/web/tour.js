/** The guided tour: six steps that set the page and say what to look at. */

import { values } from "./curves.js";
import { change, state } from "./store.js";
import { openTab } from "./tabs.js";
import { theSet } from "./theset.js";

const SHOWN = { domain: "", class: "", modality: "" }; // no filter hides what a step speaks of

/** Each step: what to set, which tab, and what to say; `n` gives a measure at a stage, now. */
const STEPS = [
  { title: "The modality gap", tab: "explore", set: { stage: "raw", colour: "modality", map: "pca", ...SHOWN },
    say: (n) => `Each circle is a photo (VIS), each triangle the touch (TAC) of the same surface. The encoder, trained on photos, puts them apart: the mean directions are <b>${n("modality_gap", "raw")}</b> from each other. Point at one to see both of its points.` },
  { title: "The domain gap", tab: "explore", set: { stage: "raw", colour: "domain", map: "pca", ...SHOWN },
    say: (n) => `Now each colour is one sensor and data set. Touch images gather by sensor, not by material: <b>${n("domain_gap", "raw")}</b> between two domains. A model that learns from one domain meets the others as strangers.` },
  { title: "The transform alone changes no distance", tab: "explore", set: { stage: "frft", colour: "modality", map: "pca", ...SHOWN },
    say: () => "Drag p, or press play. Nothing moves: the fractional Fourier transform is unitary, so it turns the space and keeps every distance. Both gap curves are flat. By itself, p is no cure." },
  { title: "What ReLU and attention add", tab: "explore", set: { stage: "f_bar", colour: "modality", map: "pca", ...SHOWN },
    say: (n) => `After the ReLU on real and imaginary parts and attention over the fractional tokens, p matters. Drag it: the modality gap is now <b>${n("modality_gap", "f_bar")}</b>, was ${n("modality_gap", "raw")}. Away from the learned p the head is lost: it was trained there.` },
  { title: "What the tree adds", tab: "tree", set: {},
    say: (n) => `The root grows into nodes at right angles to one another; their mean is added to both modalities. On the map that is F̂: domain gap <b>${n("domain_gap", "f_hat")}</b>, accuracy <b>${n("accuracy", "f_hat")}</b> over all pairs.` },
  { title: "What the figures do not show", tab: "data", set: {},
    say: () => "A small gap is not a good model: features that are all alike have none. Where the data are simulated, no accuracy here is a result on real sensors. And one head of one source domain says little of the method. The page Data &amp; about says what is loaded and what is exact." },
];

export async function startTour() {
  if (document.querySelector(".tour")) return;
  const { frames } = await theSet();
  const box = document.createElement("div");
  box.className = "ov tour";
  box.setAttribute("role", "dialog");
  box.setAttribute("aria-label", "Guided tour");
  document.querySelector(".gradio-container").append(box);
  const before = { stage: state.stage, colour: state.colour, map: state.map };
  let at = 0;

  const figure = (name, stage) => {
    const value = values(frames, name, stage)?.[frames.stop(state.p ?? 0.5)];
    return Number.isFinite(value) ? value.toFixed(2) : "not measured";
  };

  function show() {
    const step = STEPS[at];
    openTab(step.tab);
    change(step.set);
    box.innerHTML = `<div><h3>${at + 1} of ${STEPS.length} · ${step.title}</h3><p aria-live="polite">${step.say(figure)}</p></div>
      <div class="row"><button type="button" class="back" ${at ? "" : "disabled"}>Back</button><button type="button" class="main next">${at + 1 < STEPS.length ? "Next" : "Done"}</button><button type="button" class="end" aria-label="End the tour">✕</button></div>`;
    box.querySelector(".next").focus({ preventScroll: true });
  }

  function end() {
    box.remove();
    change(before);
  }

  box.onclick = (event) => {
    if (event.target.matches(".end") || (event.target.matches(".next") && at + 1 === STEPS.length)) return end();
    if (event.target.matches(".next")) at += 1;
    else if (event.target.matches(".back")) at -= 1;
    else return;
    show();
  };
  box.onkeydown = (event) => {
    if (event.key === "Escape") end(); // no value: a false one would call off the Enter key
  };
  show();
}
