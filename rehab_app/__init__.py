"""Hand rehabilitation: from photons to prescription, and the clinic's screen."""

__version__ = "0.1.0"
