/** Files of profiles: mean and variance of each embedding channel over pictures without labels. No DOM here. */

import { IMAGES } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { PROFILE } from "./rules.js";
import { tensors, written } from "./tensors.js";

const DAMAGED = "The file of the profile is damaged; save it again from this page.";

/** A profile from a file's tensors; `key` and `width`: of the encoder that it has to be of.
 * @param {Record<string, any>} file @param {Key} [key] @param {number} [width] @returns {SensorProfile} */
export function profileFrom(file, key, width) {
  const about = file.__metadata__ ?? {};
  if (about.format !== PROFILE.FORMAT)
    throw new Refusal("The file is not a profile of a sensor; save one from this page.");
  /** @type {SensorProfile["channels"]} */
  const channels = {};
  for (const name of IMAGES.filter((image) => file[`${image}_mean`]))
    channels[name] = soundChannels(file[`${name}_mean`], file[`${name}_variance`], about[`${name}_count`]);
  const widths = Object.values(channels).map(({ mean }) => mean.length);
  const { step = "1" } = about;
  if (new Set(widths).size !== 1 || !/^[\d.e-]+$/i.test(step) || !(Number(step) >= 0 && Number(step) <= 1))
    throw new Refusal(DAMAGED);
  const own = [about.encoder, about.weights_hash, about.preprocessing].join();
  if (key && (own !== [key.name, key.weights_hash, key.preprocessing].join() || widths[0] !== width))
    throw new Refusal(
      `The profile comes from ${about.encoder} (width ${widths[0]}), and this head's encoder is ${key.name} (width ` +
        `${width}) with other weights or preprocessing.`,
    );
  return { channels, step: Number(step), domain: about.domain };
}

/** The statistics of one image; a Refusal unless they are finite vectors of one length over a whole number of pictures.
 * @param {any} mean @param {any} variance @param {string} counted @returns {Channels} */
function soundChannels(mean, variance, counted) {
  const sound =
    [mean, variance].every((one) => one?.dtype === "F32" && one.shape.length === 1 && one.shape[0] === mean.shape[0]) &&
    [mean, variance].every(({ values }) => values.length && values.every(Number.isFinite)) &&
    variance.values.every((/** @type {number} */ value) => value >= 0) &&
    /^\d+$/.test(counted) &&
    Number(counted) > 0 &&
    Number(counted) < PROFILE.MOST;
  if (!sound) throw new Refusal(DAMAGED);
  return { mean: mean.values, variance: variance.values, count: Number(counted) };
}

/** A profile from the bytes of a file. @param {Uint8Array} bytes @param {Key} key @param {number} width */
export const loaded = (bytes, key, width) => profileFrom(tensors(bytes.slice().buffer, "the profile"), key, width);

/** The file of a profile, for this page, the server's and `--profile`. @param {SensorProfile} profile @param {Key} key */
export function saved({ channels, domain = PROFILE.DOMAIN }, { name, weights_hash, preprocessing }) {
  /** @type {Record<string, string>} */
  const metadata = { format: PROFILE.FORMAT, encoder: name, weights_hash, preprocessing, domain };
  /** @type {Record<string, Floats>} */
  const vectors = {};
  for (const [image, { mean, variance, count }] of Object.entries(channels)) {
    Object.assign(vectors, { [`${image}_mean`]: mean, [`${image}_variance`]: variance });
    metadata[`${image}_count`] = String(count);
  }
  return written(vectors, metadata);
}
