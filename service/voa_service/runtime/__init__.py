"""The running process: queues and threads, caches, changes and who follows them, memory, metrics, logs, the end."""
