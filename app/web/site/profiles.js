/** Profiles: mean and variance of each embedding channel over pictures without labels. No DOM here. */

import { IMAGES } from "../shared/images.js";
import { Refused } from "./refusal.js";
import { PROFILE } from "./rules.js";
import { mean as meanOf, tensors, written } from "./tensors.js";

const { FORMAT, MEAN_PRIOR, VARIANCE_PRIOR, FLOOR } = PROFILE;

/** The statistics of rows. @param {Floats[]} rows @returns {Channels} */
export function channelsOf(rows) {
  const channel = (/** @type {number} */ i) => rows.map((row) => row[i]);
  const mean = Float64Array.from(rows[0], (_, i) => meanOf(channel(i)));
  const variance = Float32Array.from(mean, (middle, i) => meanOf(channel(i).map((value) => (value - middle) ** 2)));
  return { mean: Float32Array.from(mean), variance, count: rows.length };
}

/** The statistics of two sets of pictures together. @param {Channels} one @param {Channels} other @returns {Channels} */
export function joined(one, other) {
  const count = one.count + other.count;
  const shares = [one.count / count, other.count / count];
  const mean = one.mean.map((value, i) => shares[0] * value + shares[1] * other.mean[i]);
  const spread = (/** @type {Channels} */ part, /** @type {number} */ i) =>
    part.variance[i] + (part.mean[i] - mean[i]) ** 2;
  const variance = mean.map((_, i) => shares[0] * spread(one, i) + shares[1] * spread(other, i));
  return { mean, variance, count };
}

/** A row of a new sensor with the source's mean and deviation, or `step` of the way; few pictures count less.
 * @param {ArrayLike<number>} row @param {Channels} target @param {Channels} source */
export function moved(row, target, source, step = 1) {
  const [share, spread] = [MEAN_PRIOR, VARIANCE_PRIOR].map((prior) => (step * target.count) / (target.count + prior));
  const floor = FLOOR * meanOf([...source.variance.map(Math.sqrt)]) || 1;
  return Float32Array.from(row, (value, i) => {
    const mean = source.mean[i] + share * (target.mean[i] - source.mean[i]);
    const variance = source.variance[i] + spread * (target.variance[i] - source.variance[i]);
    return ((value - mean) * (Math.sqrt(source.variance[i]) + floor)) / (Math.sqrt(variance) + floor) + source.mean[i];
  });
}

/** A profile from a file's tensors; `key`: the encoder that it has to be of.
 * @param {Record<string, any>} file @param {Key | null} key @returns {SensorProfile} */
export function profileFrom(file, key = null) {
  const about = file.__metadata__ ?? {};
  if (about.format !== FORMAT) throw new Refused("The file is not a profile of a sensor; save one from this page.");
  const own = [about.encoder, about.weights_hash, about.preprocessing].join();
  if (key && own !== [key.name, key.weights_hash, key.preprocessing].join())
    throw new Refused(
      `The profile comes from ${about.encoder}, and this head's encoder is ${key.name} with other weights or preprocessing.`,
    );
  /** @type {SensorProfile["channels"]} */
  const channels = {};
  const widths = new Set();
  for (const name of IMAGES.filter((image) => file[`${image}_mean`])) {
    const [mean, variance] = ["mean", "variance"].map((what) => file[`${name}_${what}`]?.values ?? []);
    const count = Number(about[`${name}_count`]);
    const sound =
      mean.every(Number.isFinite) && variance.every((/** @type {number} */ one) => one >= 0 && one < Infinity);
    widths.add(sound && mean.length === variance.length && count > 0 && count < 1e12 ? mean.length : 0);
    channels[name] = { mean, variance, count };
  }
  if (widths.size !== 1 || widths.has(0))
    throw new Refused("The file of the profile is damaged; save it again from this page.");
  return { channels, step: Number(about.step ?? 1), domain: about.domain };
}

/** A profile from the bytes of a file. @param {Uint8Array} bytes @param {Key} key */
export const loaded = (bytes, key) => profileFrom(tensors(bytes.slice().buffer, "the profile"), key);

/** The file of a profile, for this page, the server's and `--profile`. @param {SensorProfile} profile @param {Key} key */
export function saved({ channels, domain = "My sensor" }, { name, weights_hash, preprocessing }) {
  /** @type {Record<string, string>} */
  const metadata = { format: FORMAT, encoder: name, weights_hash, preprocessing, domain };
  /** @type {Record<string, Float32Array>} */
  const vectors = {};
  for (const [image, { mean, variance, count }] of Object.entries(channels)) {
    Object.assign(vectors, { [`${image}_mean`]: mean, [`${image}_variance`]: variance });
    metadata[`${image}_count`] = String(count);
  }
  return written(vectors, metadata);
}
