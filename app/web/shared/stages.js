/** The steps of the head, with an explanation of each. */

import { can, modeOf, TABLES } from "./tables.js";
import { joined } from "./text.js";

const { stages } = TABLES;
/** The encoder's output, and the step whose features are classified. */
export const [INPUT, OUTPUT] = ["input", "output"].map((one) => stages.find((row) => can(row, one))?.id ?? "");

/** Return the step of this name, or the last. @param {string} name */
export const stageNamed = (name) => stages.find(({ id }) => id === name) ?? stages[stages.length - 1];

/** Return a stage in words, for the frames shown. @param {Stage} stage @param {Frames} frames */
export const explained = ({ id, help, fixed }, frames) =>
  joined([help, fixed && (isStill(id, frames) ? fixed : modeOf(frames).moving)], " ");

/** Return the stage whose map is shown: the transform keeps all distances of the projection. @param {string} stage */
export const featuresOf = (stage) => stages.find(({ id }) => id === stage)?.as ?? stage;

/** Return the steps of a head: with its projection, if raw and projected embeddings have two maps; the embedding alone
 * without a head.
 * @param {Frames} frames */
export const stepsOf = ({ headless, meta: { maps } }) =>
  stages.filter(({ id, as }) =>
    headless ? id === INPUT : !as || maps[`pca/${INPUT}`]?.array !== maps[`pca/${as}`]?.array,
  );

/** Return whether map and gaps of a stage do not depend on p: where the step is rigid and these frames have one map of
 * it.
 * @param {string} stage @param {Pick<Frames, "meta">} frames */
export const isStill = (stage, { meta: { maps } }) =>
  stage === INPUT || (can(stageNamed(stage), "rigid") && (maps[`pca/${featuresOf(stage)}`]?.orders.length ?? 1) === 1);
