/** The steps of the head, with an explanation of each. */

export const STAGES = [
  {
    key: "raw",
    brief: "raw",
    short: "E",
    name: "Raw embedding",
    step: "embedding",
    colour: "#94a3b8",
    explain: "The frozen encoder’s output. It does not depend on p, so nothing moves here.",
  },
  {
    key: "projection",
    brief: "proj.",
    short: "E′",
    name: "Projection",
    step: "projection",
    colour: "#7c8aa5",
    explain: "The head first projects E to its own width. That changes the gaps; p does not change them.",
  },
  {
    key: "frft",
    brief: "DFrFT",
    short: "F_p",
    name: "Transform",
    step: "transform",
    colour: "#475569",
    explain:
      "The fractional Fourier transform is unitary: it rotates the whole space and keeps every distance and every cosine, at every p.",
  },
  {
    key: "relu",
    brief: "ReLU",
    short: "F",
    name: "F after ReLU",
    step: "ReLU",
    colour: "#0284c7",
    explain:
      "The ReLU clips the real and the imaginary part. At each p, it clips a different part of the space, so from here on distances depend on p.",
  },
  {
    key: "f_bar",
    brief: "FrATT",
    short: "F̄",
    name: "F̄ after FrATT",
    step: "attention",
    colour: "#d97706",
    explain:
      "Attention over the fractional tokens of each image. Compare gaps and margin with those of the previous step: where all fall, the classes have moved together, too.",
  },
  {
    key: "f_hat",
    brief: "DTG",
    short: "F̂",
    name: "F̂ after DTG",
    step: "tree",
    colour: "#7c3aed",
    explain:
      "The mean of the tree’s nodes is added to both modalities. These features are classified, so accuracy belongs to this step.",
  },
];

const LAST = STAGES[STAGES.length - 1];
export const stageNamed = (key) => STAGES.find((stage) => stage.key === key) ?? LAST;

/** A stage in words, for the frames shown. */
export function explained(stage, { kind }) {
  if (stage.key !== "frft") return stage.explain;
  return kind === "retrained"
    ? `${stage.explain} Each stop is another head with another projection, so its map and gaps differ.`
    : `${stage.explain} No point moves, and both gaps are flat lines.`;
}

/** The stage whose map is shown: the transform keeps all distances of the projection. */
export const featuresOf = (stage) => (stage === "projection" ? "frft" : stage);

/** True if the head projects E, so that raw and projected embeddings have two maps. */
export const projects = ({ headless, meta: { maps } }) =>
  !headless && maps["pca/raw"]?.array !== maps["pca/frft"]?.array;

/** The steps of a head; the embedding alone without one. */
export const stepsOf = (frames) =>
  STAGES.filter(({ key }) => (frames.headless ? key === "raw" : key !== "projection" || projects(frames)));

/** Stages whose map and gaps do not depend on p. */
export const isStill = (stage, frames) =>
  stage === "raw" || (["projection", "frft"].includes(stage) && frames.kind !== "retrained");
