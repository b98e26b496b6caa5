"""How much the page takes in at once."""

MAX_IMAGE_BYTES = 20_000_000  # a phone's photo is 3 to 12 MB
MAX_PIXELS = 64_000_000  # the library reads no more; said in the page
IMAGE_MEMORY = 200_000_000  # bytes that all pictures being decoded may hold together
DECODE_S = 3  # seconds of a processor that decoding one picture may take
DECODE_WAIT_S = 8  # seconds after which it is killed, however busy the machine is
DECODER_BYTES = 220_000_000  # of memory of such a process
IDLE_S = 20  # seconds without a byte of what a visitor sends
BODY_S = 600  # seconds in all for what a visitor sends
MAX_QUESTION_BYTES = 10_000
SLOTS = {"quick": 2, "long": 1}  # jobs that run at a time: questions; maps and training
WAITING_JOBS = 200  # in one lane; more are refused
OWN_JOBS = 6  # of one owner in one lane
DRAWN_PAIRS = 20_000  # of a larger set that many are drawn at random, and the page says so
LARGE_SET = 4_000  # pairs from which the first look is PCA alone, at two stops
KEPT_DESKS = 3  # heads or sets loaded through the page, each with a map of its own
KEPT_PARTS = 200  # files that have arrived; who sends more waits until some are old
PARTS_BYTES = 2_000_000_000  # of them together
PART_S = 600  # seconds that they are kept for certain
# files of a head or a set that the page takes, and the largest size of each
PARTS = {
    "weights.safetensors": 64_000_000,
    "settings.json": 1_000_000,
    "metrics.json": 5_000_000,
    "familiarity.safetensors": 64_000_000,
    "embeddings.safetensors": 256_000_000,
    "embeddings.thumbnails.webp": 32_000_000,
    "embeddings.thumbnails.json": 100_000,
}
