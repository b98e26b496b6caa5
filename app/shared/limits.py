"""Limits of the page."""

MAX_IMAGE_BYTES = 20_000_000  # a phone's photo is 3 to 12 MB
DECODE_S = 3  # CPU seconds to decode one picture
DECODE_WAIT_S = 30  # seconds after which decoding is killed; a busy machine is slow to start it
DECODER_BYTES = 220_000_000  # memory of such a process
IDLE_S = 20  # seconds of an idle connection, of a request's head, and without a byte of an upload
BODY_S = 600  # seconds for a whole upload
SLOWEST = 10_000  # bytes a second of a reader; each further unread byte has its time beside IDLE_S
CONNECTIONS = 400  # open ones; a request on a further one gets 503
# of one address, behind which a class may be: half of everything stays for the others
SHARE = CONNECTIONS // 2  # connections
AT_ONCE = 100  # requests at a time; more wait
UPLOADS = 8  # uploads that arrive at a time; more wait
SMALL_QUESTION_BYTES = 10_000  # a larger one waits on the disk
MAX_QUESTION_BYTES = 4_000_000  # 60 labelled pairs of own pictures have less than 2 MB
PICTURES = 50  # that come with one question
MAX_PICTURES_BYTES = 2 * MAX_IMAGE_BYTES + MAX_QUESTION_BYTES  # of them and the question
MAX_API_BYTES = 4_000_000  # of a request to the API, small pictures included
REPORT_S = 600  # seconds of a report by the API
SLOTS = {"quick": 2, "long": 1}  # jobs that run at a time: requests; maps and training
LONGEST_WAIT_S = 1.0  # of an upload behind newer requests without a picture
GIVE_WAY_S = 0.1  # longest wait of each training step while requests run or wait
WAITING_JOBS = 200  # in one lane; more are refused
DRAWN_PAIRS = 20_000  # a larger set is sampled to this many pairs, and the page shows that
MAPPED_BYTES = 1_000_000  # larger arrays of a set stay in its file
LARGE_SET = 400  # from this many pairs on, the first maps are PCA at two stops
KEPT_DESKS = 16  # heads or sets loaded through the page
DESKS_BYTES = 1_000_000_000  # total size of their files; one more may be above
KEPT_PARTS = 1000  # uploaded files that are not loaded yet; the oldest are dropped
PARTS_BYTES = 2_000_000_000  # total size of them; a head and a set have at most 422 MB
# accepted files of a head or set, and the largest size of each
PARTS = {
    "weights.safetensors": 64_000_000,
    "settings.json": 1_000_000,
    "metrics.json": 5_000_000,
    "familiarity.safetensors": 64_000_000,
    "profile.safetensors": 4_000_000,
    "embeddings.safetensors": 256_000_000,
    "embeddings.thumbnails.webp": 32_000_000,
    "embeddings.thumbnails.json": 100_000,
}
