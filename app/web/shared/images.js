/** The two images of a pair. No DOM here. */

/** @type {Modality[]} */
export const IMAGES = ["vis", "tac"];
/** @type {Record<Modality, Modality>} */
export const OTHER = { vis: "tac", tac: "vis" };

/** A branch inside a pair is not a reading. @type {Reading[]} */
export const READINGS = ["fused", ...IMAGES];

/** The images that a pair or its readings have. @param {Partial<Record<Modality, unknown>>} of */
export const imagesOf = (of) => IMAGES.filter((name) => of[name]);
