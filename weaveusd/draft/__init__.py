"""Drafts: the WIF reader and writer, standard weaves, and pictures of them."""
