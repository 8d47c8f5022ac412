"""What pytest leaves out: the doctests of modules whose framework is not installed."""

from importlib.util import find_spec

collect_ignore = [] if find_spec("torch") else ["ylm/torch.py"]
