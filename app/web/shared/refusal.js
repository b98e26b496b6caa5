/** An error for the visitor, in a sentence, with the status of a reply; any other error is a bug and stays one. */
export class Refusal extends Error {
  /** @param {string} sentence */
  constructor(sentence, status = 0) {
    super(sentence);
    this.status = status;
  }
}
