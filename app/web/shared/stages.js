/** The steps of the head, with an explanation of each. */

import { has, TABLES } from "./tables.js";

const { stages } = TABLES;

/** The step of this name, or the last. @param {string} name */
export const stageNamed = (name) => stages.find(({ id }) => id === name) ?? stages[stages.length - 1];

/** A stage in words, for the frames shown. @param {Stage} stage @param {{kind: string}} frames */
export function explained(stage, frames) {
  if (stage.id !== "frft") return stage.help;
  return has(frames, "heads")
    ? `${stage.help} Each stop is another head with another projection, so its map and gaps differ.`
    : `${stage.help} No point moves, and both gaps are flat lines.`;
}

/** The stage whose map is shown: the transform keeps all distances of the projection. @param {string} stage */
export const featuresOf = (stage) => (stage === "projection" ? "frft" : stage);

/** The steps of a head: with its projection, if raw and projected embeddings have two maps; the embedding alone without
 * a head. @param {Frames} frames */
export const stepsOf = ({ headless, meta: { maps } }) =>
  stages.filter(({ id }) =>
    headless ? id === "raw" : id !== "projection" || maps["pca/raw"]?.array !== maps["pca/frft"]?.array,
  );

/** Stages whose map and gaps do not depend on p. @param {string} stage @param {{kind: string}} frames */
export const isStill = (stage, frames) =>
  stage === "raw" || (["projection", "frft"].includes(stage) && !has(frames, "heads"));
