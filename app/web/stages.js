/** The stages of the features, and what each teaches while p moves. */

export const STAGES = [
  { key: "raw", brief: "raw", short: "E", name: "Raw embedding",
    explain: "What the frozen encoder gives. It does not know p, so nothing here moves: VIS and TAC lie apart, and so do the domains." },
  { key: "frft", brief: "DFrFT", short: "F_p(E)", name: "Raw DFrFT",
    explain: "Why does nothing move? The fractional Fourier transform is unitary: it turns the whole space and keeps every distance and every cosine, for every p. So both gaps are flat lines." },
  { key: "relu", brief: "ReLU", short: "F", name: "F after ReLU",
    explain: "The ReLU on real and imaginary parts is what makes p matter: it cuts off a different half of the space for each p, and distances change." },
  { key: "f_bar", brief: "FrATT", short: "F̄", name: "F̄ after FrATT",
    explain: "Attention over the fractional tokens, with the bank of class tokens, has pulled the two modalities towards a shared space." },
  { key: "f_hat", brief: "DTG", short: "F̂", name: "F̂ after DTG",
    explain: "The tree’s mean is added to each modality. These are the features that are classified; accuracy is read from them." },
];
export const stageNamed = (key) => STAGES.find((stage) => stage.key === key) ?? STAGES[4];

export function stageButtons(box, chosen, onChoose) {
  box.innerHTML = STAGES.map((s) =>
    `<button type="button" role="radio" data-stage="${s.key}"><b>${s.short.replace("_p", "<sub>p</sub>")}</b> <span class="long">${s.name.replace(/^F[̄̂]? /, "")}</span><span class="brief">${s.brief}</span></button>`).join("");
  const buttons = [...box.querySelectorAll("button")];
  const show = () => buttons.forEach((b) => {
    const on = b.dataset.stage === chosen();
    b.setAttribute("aria-checked", on);
    b.tabIndex = on ? 0 : -1;
  });
  box.onclick = (event) => {
    const button = event.target.closest("button");
    if (button) onChoose(button.dataset.stage);
  };
  box.onkeydown = (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const at = buttons.findIndex((b) => b.dataset.stage === chosen());
    const next = buttons[(at + by + buttons.length) % buttons.length];
    onChoose(next.dataset.stage);
    next.focus();
  };
  show();
  return show;
}
