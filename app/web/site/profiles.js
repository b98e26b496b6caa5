/** Profiles: mean and variance of each embedding channel over pictures without labels. No DOM here. */

import { IMAGES } from "../shared/images.js";
import { Refused } from "./refusal.js";
import { mean as meanOf, tensors, written } from "./tensors.js";

const FORMAT = "omnivat-profile-1";
const MEAN_PRIOR = 4; // pictures that the source's mean weighs
const VARIANCE_PRIOR = 10;

/** {mean, variance, count} of rows. */
export function channelsOf(rows) {
  const [mean, variance] = [new Float32Array(rows[0].length), new Float32Array(rows[0].length)];
  for (let i = 0; i < mean.length; i++) {
    const own = rows.map((row) => row[i]);
    const middle = meanOf(own);
    mean[i] = middle;
    variance[i] = meanOf(own.map((value) => (value - middle) ** 2));
  }
  return { mean, variance, count: rows.length };
}

/** The statistics of two sets of pictures together. */
export function joined(one, other) {
  const count = one.count + other.count;
  const shares = [one.count / count, other.count / count];
  const mean = one.mean.map((value, i) => shares[0] * value + shares[1] * other.mean[i]);
  const spread = (part, i) => part.variance[i] + (part.mean[i] - mean[i]) ** 2;
  const variance = mean.map((_, i) => shares[0] * spread(one, i) + shares[1] * spread(other, i));
  return { mean, variance, count };
}

/** A row of a new sensor with the source's mean and deviation, or `step` of the way; few pictures count less. */
export function moved(row, target, source, step = 1) {
  const [share, spread] = [MEAN_PRIOR, VARIANCE_PRIOR].map((prior) => (step * target.count) / (target.count + prior));
  const floor = meanOf(source.variance.map(Math.sqrt)) || 1;
  return Float32Array.from(row, (value, i) => {
    const mean = source.mean[i] + share * (target.mean[i] - source.mean[i]);
    const variance = source.variance[i] + spread * (target.variance[i] - source.variance[i]);
    return ((value - mean) * (Math.sqrt(source.variance[i]) + floor)) / (Math.sqrt(variance) + floor) + source.mean[i];
  });
}

/** A profile from a file's bytes or tensors; `key`: the encoder that it has to be of. */
export function profileFrom(file, /** @type {any} */ key = null) {
  const found = file instanceof ArrayBuffer ? tensors(file, "the profile") : file;
  const about = found.__metadata__ ?? {};
  if (about.format !== FORMAT) throw new Refused("The file is not a profile of a sensor; save one from this page.");
  const own = [about.encoder, about.weights_hash, about.preprocessing].join();
  if (key && own !== [key.name, key.weights_hash, key.preprocessing].join())
    throw new Refused(
      `The profile comes from ${about.encoder}, and this head's encoder is ${key.name} with other weights or preprocessing.`,
    );
  const names = IMAGES.filter((name) => found[`${name}_mean`]);
  const parts = names.map((name) => {
    const [mean, variance] = ["mean", "variance"].map((what) => found[`${name}_${what}`]?.values ?? []);
    const count = Number(about[`${name}_count`]);
    const sound = mean.every(Number.isFinite) && variance.every((value) => value >= 0 && value < Infinity);
    if (!sound || !mean.length || mean.length !== variance.length || !(count > 0 && count < 1e12))
      throw new Refused("The file of the profile is damaged; save it again from this page.");
    return [name, { mean, variance, count }];
  });
  if (new Set(names.map((name) => found[`${name}_mean`].values.length)).size !== 1)
    throw new Refused("The file of the profile is damaged; save it again from this page.");
  return { channels: Object.fromEntries(parts), domain: about.domain, step: Number(about.step ?? 1) };
}

/** The file of a profile, for this page, the server's and `--profile`. */
export function saved({ channels, domain = "My sensor" }, key) {
  const metadata = {
    format: FORMAT,
    encoder: key.name,
    weights_hash: key.weights_hash,
    preprocessing: key.preprocessing,
    domain,
  };
  const vectors = {};
  for (const [name, one] of Object.entries(channels)) {
    Object.assign(vectors, { [`${name}_mean`]: one.mean, [`${name}_variance`]: one.variance });
    metadata[`${name}_count`] = String(one.count);
  }
  return written(vectors, metadata);
}
