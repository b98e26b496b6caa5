/** The steps of the head, with an explanation of each. */

import { has, TABLES } from "./tables.js";

export const STAGES = TABLES.stages.map(({ id, title, help, ...more }) => ({
  ...{ key: id, name: title, explain: help },
  ...more,
}));

const LAST = STAGES[STAGES.length - 1];
export const stageNamed = (key) => STAGES.find((stage) => stage.key === key) ?? LAST;

/** A stage in words, for the frames shown. */
export function explained(stage, frames) {
  if (stage.key !== "frft") return stage.explain;
  return has(frames, "heads")
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
  stage === "raw" || (["projection", "frft"].includes(stage) && !has(frames, "heads"));
