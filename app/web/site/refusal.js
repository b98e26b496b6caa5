/** A sentence for the visitor, with the status of a server's reply. */
export class Refused extends Error {
  /** @param {string} sentence */
  constructor(sentence, status = 400) {
    super(sentence);
    this.status = status;
  }
}
