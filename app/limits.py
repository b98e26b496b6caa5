"""Limits of the page."""

MAX_IMAGE_BYTES = 20_000_000  # a phone's photo is 3 to 12 MB
MAX_PIXELS = 64_000_000  # the library's limit, shown in the page
IMAGE_MEMORY = 200_000_000  # memory for all pictures being decoded
DECODE_S = 3  # CPU seconds to decode one picture
DECODE_WAIT_S = 8  # seconds after which decoding is killed
DECODER_BYTES = 220_000_000  # memory of such a process
IDLE_S = 20  # seconds without a byte of an upload
BODY_S = 600  # seconds for a whole upload
MAX_QUESTION_BYTES = 10_000
SLOTS = {"quick": 2, "long": 1}  # jobs that run at a time: requests; maps and training
WAITING_JOBS = 200  # in one lane; more are refused
OWN_JOBS = 6  # of one owner in one lane
DRAWN_PAIRS = 20_000  # a larger set is sampled to this many pairs, and the page shows that
LARGE_SET = 400  # from this many pairs on, the first maps are PCA at two stops
KEPT_DESKS = 3  # heads or sets loaded through the page
KEPT_PARTS = 200  # uploaded files; more must wait until some are old
PARTS_BYTES = 2_000_000_000  # total size of them
PART_S = 600  # seconds that they are kept at least
# accepted files of a head or set, and the largest size of each
PARTS = {
    "weights.safetensors": 64_000_000,
    "settings.json": 1_000_000,
    "metrics.json": 5_000_000,
    "familiarity.safetensors": 64_000_000,
    "embeddings.safetensors": 256_000_000,
    "embeddings.thumbnails.webp": 32_000_000,
    "embeddings.thumbnails.json": 100_000,
}
