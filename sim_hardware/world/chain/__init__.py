"""The sheet as a chain of rigid links, at rest: free, held, and over its drive."""
