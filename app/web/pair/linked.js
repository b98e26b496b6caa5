/** Pictures that the address names: `?tab=pair&vis=URL&tac=URL`, of the page's own origin. */

import { Refusal, refused } from "../shared/api.js";
import { links, state } from "../shared/store.js";
import { upload } from "./many.js";
import { TERMS } from "./verdict.js";

const REFERENCE = /^(row|example|image):/;

/** Send the pictures of the address; they then are references like others. Returns what went wrong, one sentence. */
export async function takeLinked() {
  const problems = await Promise.all(Object.keys(TERMS).map(takeOne));
  return problems.filter(Boolean).join(" ");
}

async function takeOne(modality) {
  const link = state[modality];
  let problem = "";
  if (!link || REFERENCE.test(link)) return problem;
  state[modality] = null;
  try {
    const ref = await upload(await fetched(link, TERMS[modality].one));
    links.set(link, ref);
    state[modality] = ref;
  } catch (error) {
    refused(error, (sentence) => (problem = sentence));
  }
  return problem;
}

/** The file at a link; a picture of another host is not fetched. */
async function fetched(link, what) {
  const url = URL.canParse(link, document.baseURI) ? new URL(link, document.baseURI) : null;
  if (!url || url.origin !== location.origin)
    throw new Refusal(`The ${what} '${link.slice(0, 80)}' is not on this page's host; open its file here instead.`);
  const response = await fetch(url).catch(() => null);
  if (!response?.ok) throw new Refusal(`The ${what} '${link.slice(0, 80)}' cannot be fetched; check its address.`);
  return new File([await response.blob()], decodeURIComponent(url.pathname.split("/").at(-1)) || what);
}
