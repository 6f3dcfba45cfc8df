"""Programs that try to break a running demo: chaos, floods, endings, hostile input, soak."""
