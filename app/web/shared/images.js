/** The two images of a pair. No DOM here. */

/** @type {Modality[]} */
export const IMAGES = ["vis", "tac"];
/** @type {Record<Modality, Modality>} */
export const OTHER = { vis: "tac", tac: "vis" };

/** A branch inside a pair is not a reading. @type {Reading[]} */
export const READINGS = ["fused", ...IMAGES];

/** Return the images that a pair or its readings have. @param {Partial<Record<Modality, unknown>>} of */
export const imagesOf = (of) => IMAGES.filter((name) => of[name]);

const PLACES = ["vis", "tac", "photos", "touches"]; // of images in a question, its pairs and its lessons

/** Return a question with `of` each of its images in their place.
 * @template {Question} Some @param {Some} question @param {(image: any) => any} of @returns {Some} */
export function withImages(question, of) {
  const filled = (/** @type {any} */ part) => {
    const images = PLACES.filter((name) => part[name]).map((name) => {
      const value = part[name];
      return [name, Array.isArray(value) ? value.map(of) : of(value)];
    });
    return { ...part, ...Object.fromEntries(images) };
  };
  const { lessons, pairs } = question;
  const many = { ...(lessons && { lessons: lessons.map(filled) }), ...(pairs && { pairs: pairs.map(filled) }) };
  return { ...filled(question), ...many };
}
