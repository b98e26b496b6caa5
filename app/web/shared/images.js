/** The two images of a pair. No DOM here. */

export const IMAGES = ["vis", "tac"];
export const OTHER = { vis: "tac", tac: "vis" };

/** The images that a pair or its readings have. */
export const imagesOf = (found) => IMAGES.filter((name) => found[name]);
