/** The two images of a pair. No DOM here. */

/** @type {Modality[]} */
export const IMAGES = ["vis", "tac"];
/** @type {Record<Modality, Modality>} */
export const OTHER = { vis: "tac", tac: "vis" };

/** The images that a pair or its readings have. @param {Partial<Record<Modality, unknown>>} of */
export const imagesOf = (of) => IMAGES.filter((name) => of[name]);
