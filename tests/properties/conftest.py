"""How many random examples are drawn: `make fuzz` draws others at each call, and more of them."""

import os

from hypothesis import HealthCheck, settings

settings.register_profile(
    "fixed",
    derandomize="FUZZ" not in os.environ,
    max_examples=int(os.environ.get("FUZZ", "160")),
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
)
settings.load_profile("fixed")
