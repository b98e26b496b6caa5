/** A recording as data sets of LeRobot in its layout v3.0. No DOM here. */

import { parquet } from "../shared/parquet.js";

/** @typedef {import("../shared/parquet.js").Column} Column */
/** @typedef {ReturnType<typeof cutUp>} Cut */
/** @typedef {(blob: Blob) => Promise<Uint8Array>} ContentOf */

const NAMES = { vis: "observation.images.photo", tac: "observation.images.tactile" };
const PLACE = "chunk-000/file-000.parquet";
/** @param {string} dtype */
const number = (dtype) => ({ dtype, shape: [1], names: null });

/**
 * Files by their paths: a folder for each set of sources and sizes of pictures, which a data set has in every frame. An
 * episode is a run of pictures with one label, its task. LeRobot wants frames at equal times, so `timestamp` counts
 * them at the mean rate, and `time` has the seconds since the recording began.
 * @param {Recorded[]} pairs @param {ContentOf} contentOf @returns {Promise<[string, Uint8Array][]>}
 */
export async function dataSets(pairs, contentOf) {
  /** @type {Map<string, Recorded[]>} */
  const groups = new Map();
  for (const pair of pairs) {
    const key = JSON.stringify(pair.pictures.map(([modality, , size]) => [modality, size]));
    groups.set(key, [...(groups.get(key) ?? []), pair]);
  }
  const sets = [...groups.values()].map(async (frames, i) => {
    const cut = cutUp(frames);
    const files = {
      "meta/info.json": new TextEncoder().encode(JSON.stringify(infoOf(frames, cut), null, 4)),
      "meta/tasks.parquet": tasksOf(cut),
      [`meta/episodes/${PLACE}`]: episodesOf(frames, cut),
      [`data/${PLACE}`]: await framesOf(frames, cut, contentOf),
    };
    const folder = `My sensor${i ? ` ${i + 1}` : ""}`;
    return Object.entries(files).map(
      ([path, file]) => /** @type {[string, Uint8Array]} */ ([`${folder}/${path}`, file]),
    );
  });
  return (await Promise.all(sets)).flat();
}

/** Which episode a frame is in, and its place there. @param {Recorded[]} frames */
function cutUp(frames) {
  const seconds = frames.map(({ time }) => (time - frames[0].time) / 1000);
  const starts = frames.flatMap(({ label }, i) => (i && label === frames[i - 1].label ? [] : [i]));
  const episodes = frames.map((_, i) => starts.findLastIndex((start) => start <= i));
  return {
    seconds,
    starts,
    episodes,
    fps: Math.max(1, Math.round((frames.length - 1) / (seconds.at(-1) || 1))),
    tasks: [...new Set(frames.map(({ label }) => label))],
    ends: starts.map((_, episode) => starts[episode + 1] ?? frames.length),
    places: frames.map((_, i) => i - starts[episodes[i]]),
  };
}

/** @param {Recorded[]} frames @param {Cut} cut */
function infoOf(frames, { fps, starts, tasks }) {
  const cameras = frames[0].pictures.map(([modality, , [width, height]]) => [
    NAMES[modality],
    { dtype: "image", shape: [height, width, 3], names: ["height", "width", "channels"] },
  ]);
  const counts = ["frame_index", "episode_index", "index", "task_index"].map((name) => [name, number("int64")]);
  const times = { time: number("float64"), timestamp: number("float32") };
  return {
    codebase_version: "v3.0",
    robot_type: "My sensor",
    total_episodes: starts.length,
    total_frames: frames.length,
    total_tasks: tasks.length,
    chunks_size: 1000,
    data_files_size_in_mb: 100,
    video_files_size_in_mb: 200,
    fps,
    splits: { train: `0:${starts.length}` },
    data_path: "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
    video_path: null,
    features: { ...Object.fromEntries(cameras), ...times, ...Object.fromEntries(counts) },
  };
}

/** @param {string} name @param {number[]} values @param {"int64" | "float" | "double"} kind @returns {Column} */
const column = (name, values, kind = "int64") => ({ name, kind, values });

/** The tasks, which pandas reads as the names of rows. @param {Cut} cut */
function tasksOf({ tasks }) {
  const columns = [
    ["task_index", "int64", "int64"],
    ["task", "unicode", "object"],
  ].map(([name, pandas_type, numpy_type]) => ({ name, field_name: name, pandas_type, numpy_type, metadata: null }));
  return parquet([column("task_index", [...tasks.keys()]), { name: "task", kind: "text", values: tasks }], {
    pandas: JSON.stringify({ index_columns: ["task"], column_indexes: [], columns }),
  });
}

/** @param {Recorded[]} frames @param {Cut} cut */
function episodesOf(frames, { starts, ends }) {
  const zeros = starts.map(() => 0);
  return parquet([
    column("episode_index", [...starts.keys()]),
    { name: "tasks", kind: "texts", values: starts.map((start) => frames[start].label) },
    column(
      "length",
      starts.map((start, episode) => ends[episode] - start),
    ),
    column("dataset_from_index", starts),
    column("dataset_to_index", ends),
    ...["data", "meta/episodes"].flatMap((place) => [
      column(`${place}/chunk_index`, zeros),
      column(`${place}/file_index`, zeros),
    ]),
  ]);
}

/** @param {Recorded[]} frames @param {Cut} cut @param {ContentOf} contentOf */
async function framesOf(frames, { seconds, places, episodes, fps, tasks }, contentOf) {
  const cameras = frames[0].pictures.map(async ([modality], k) => {
    const values = await Promise.all(frames.map(({ pictures }) => contentOf(pictures[k][1])));
    return /** @type {Column} */ ({ name: NAMES[modality], kind: "image", values });
  });
  const times = places.map((place) => place / fps);
  const tasksNow = frames.map(({ label }) => tasks.indexOf(label));
  return parquet([
    ...(await Promise.all(cameras)),
    column("time", seconds, "double"),
    column("timestamp", times, "float"),
    column("frame_index", places),
    column("episode_index", episodes),
    column("index", [...frames.keys()]),
    column("task_index", tasksNow),
  ]);
}
