"""What is shown while a job runs: messages, frames, strip charts."""
