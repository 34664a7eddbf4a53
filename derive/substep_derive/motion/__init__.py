"""Scenes' equations of motion, and what a scheme's step solves on them."""
