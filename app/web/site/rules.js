/** Numbers of the library, written by `python -m app.site_rules`. */

export const DOTS = {
  SIDE: 224,
  WIDEST: 0.085,
  LONGEST: 0.28,
  SHORTEST: 11,
  MOST: 256,
  FAINTEST: 26,
  NODES: 16,
  SUPPORT: 0.22,
  STRAY: 0.24,
  FAINT: [0.35, 0.7],
  SMALLEST: 64,
  SWEEPS: 2,
};
export const PICTURE = {
  MOST_JPEG: 64000000,
  MOST: 24000000,
  SHORT_SIDE: 1024,
  REDUCED: 6000000,
  LEAST_SIDE: 8,
  STRIP: 1000000,
  PREVIEW: 320,
  HIDDEN: 448,
};
export const PAIR = {
  STOPS: 101,
  COLUMNS: 256,
  NEAREST: 3,
  NEIGHBOURS: 6,
  READINGS: ["fused", "vis", "tac", "vis_branch", "tac_branch"],
  WORDS: ["unlike the training images", "familiar"],
  UNLIKE: 0.05,
  MOST_LESSONS: 60,
  LONGEST_LABEL: 40,
};
export const PROFILE = { FORMAT: "omnivat-profile-1", MOST: 1000000000000, DOMAIN: "My sensor" };
