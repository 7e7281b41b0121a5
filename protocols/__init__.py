"""What happens when: a schedule is plain data, and the scheduler runs one on a clock."""
