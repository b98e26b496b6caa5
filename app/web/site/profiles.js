/** Profiles: mean and variance of each embedding channel over pictures without labels. No DOM here. */

import { IMAGES } from "../shared/images.js";
import { Refusal } from "../shared/refusal.js";
import { PROFILE } from "./rules.js";
import { mean as meanOf, tensors, written } from "./tensors.js";

const { FORMAT, MEAN_PRIOR, VARIANCE_PRIOR, FLOOR } = PROFILE;

/** The statistics of one picture. @param {Floats} row @returns {Channels} */
export const channelsOf = (row) => ({ mean: Float64Array.from(row), variance: new Float64Array(row.length), count: 1 });

/** The statistics of two sets of pictures together. @param {Channels} one @param {Channels} other @returns {Channels} */
export function joined(one, other) {
  const count = one.count + other.count;
  const share = other.count / count;
  const mean = Float64Array.from(one.mean, (value, i) => value + share * (other.mean[i] - value));
  const variance = mean.map((_, i) => {
    const apart = (1 - share) * share * (one.mean[i] - other.mean[i]) ** 2;
    return (1 - share) * one.variance[i] + share * other.variance[i] + apart;
  });
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
  if (about.format !== FORMAT) throw new Refusal("The file is not a profile of a sensor; save one from this page.");
  const own = [about.encoder, about.weights_hash, about.preprocessing].join();
  if (key && own !== [key.name, key.weights_hash, key.preprocessing].join())
    throw new Refusal(
      `The profile comes from ${about.encoder}, and this head's encoder is ${key.name} with other weights or preprocessing.`,
    );
  /** @type {SensorProfile["channels"]} */
  const channels = {};
  for (const name of IMAGES.filter((image) => file[`${image}_mean`])) {
    const [mean, variance] = ["mean", "variance"].map((what) => file[`${name}_${what}`]?.values ?? []);
    channels[name] = { mean, variance, count: Number(about[`${name}_count`]) };
  }
  const parts = Object.values(channels);
  const sound = parts.every(
    ({ mean, variance, count }) =>
      [mean, variance].every(({ length }) => length === parts[0].mean.length) &&
      [...mean, ...variance].every(Number.isFinite) &&
      Math.min(...variance, count - 1) >= 0 &&
      count < 1e12,
  );
  if (!parts.length || !sound) throw new Refusal("The file of the profile is damaged; save it again from this page.");
  return { channels, step: Number(about.step ?? 1), domain: about.domain };
}

/** A profile from the bytes of a file. @param {Uint8Array} bytes @param {Key} key */
export const loaded = (bytes, key) => profileFrom(tensors(bytes.slice().buffer, "the profile"), key);

/** The file of a profile, for this page, the server's and `--profile`. @param {SensorProfile} profile @param {Key} key */
export function saved({ channels, domain = "My sensor" }, { name, weights_hash, preprocessing }) {
  /** @type {Record<string, string>} */
  const metadata = { format: FORMAT, encoder: name, weights_hash, preprocessing, domain };
  /** @type {Record<string, Floats>} */
  const vectors = {};
  for (const [image, { mean, variance, count }] of Object.entries(channels)) {
    Object.assign(vectors, { [`${image}_mean`]: mean, [`${image}_variance`]: variance });
    metadata[`${image}_count`] = String(count);
  }
  return written(vectors, metadata);
}
