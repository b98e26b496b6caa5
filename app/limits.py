"""How much the page takes in at once."""

MAX_IMAGE_BYTES = 20_000_000  # a phone's photo is 3 to 12 MB
MAX_PIXELS = 64_000_000  # the library reads no more; said in the page
MAX_QUESTION_BYTES = 10_000
LANES = 2  # heavy questions answered at a time; others wait
KEPT_DESKS = 3  # heads or sets loaded through the page, each with a map of its own
KEPT_PARTS = 8  # files that have arrived and are not used yet
# files of a head or a set that the page takes, and the largest size of each
PARTS = {
    "weights.safetensors": 64_000_000,
    "settings.json": 1_000_000,
    "metrics.json": 5_000_000,
    "embeddings.safetensors": 256_000_000,
    "embeddings.thumbnails.webp": 32_000_000,
    "embeddings.thumbnails.json": 100_000,
}
