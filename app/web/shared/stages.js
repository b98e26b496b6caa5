/** The steps of the head, with an explanation of each. */

import { has, TABLES } from "./tables.js";

/** @type {Stage[]} */
export const STAGES = TABLES.stages.map(({ id, title, help, ...more }) => ({
  ...{ key: id, name: title, explain: help },
  ...more,
}));

const LAST = STAGES[STAGES.length - 1];
/** @param {string} key */
export const stageNamed = (key) => STAGES.find((stage) => stage.key === key) ?? LAST;

/** A stage in words, for the frames shown. @param {Stage} stage @param {{kind: string}} frames */
export function explained(stage, frames) {
  if (stage.key !== "frft") return stage.explain;
  return has(frames, "heads")
    ? `${stage.explain} Each stop is another head with another projection, so its map and gaps differ.`
    : `${stage.explain} No point moves, and both gaps are flat lines.`;
}

/** The stage whose map is shown: the transform keeps all distances of the projection. @param {string} stage */
export const featuresOf = (stage) => (stage === "projection" ? "frft" : stage);

/** The steps of a head: with its projection, if raw and projected embeddings have two maps; the embedding alone without
 * a head. @param {Frames} frames */
export const stepsOf = ({ headless, meta: { maps } }) =>
  STAGES.filter(({ key }) =>
    headless ? key === "raw" : key !== "projection" || maps["pca/raw"]?.array !== maps["pca/frft"]?.array,
  );

/** Stages whose map and gaps do not depend on p. @param {string} stage @param {{kind: string}} frames */
export const isStill = (stage, frames) =>
  stage === "raw" || (["projection", "frft"].includes(stage) && !has(frames, "heads"));
