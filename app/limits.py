"""How much the page takes in at once."""

MAX_IMAGE_BYTES = 20_000_000  # a phone's photo is 3 to 12 MB
MAX_PIXELS = 64_000_000  # the library reads no more; said in the page
MAX_QUESTION_BYTES = 10_000
LANES = 2  # heavy questions answered at a time; others wait
