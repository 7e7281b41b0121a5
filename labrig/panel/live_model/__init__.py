"""The dynamic model beside a run: its prediction, its running error, its slow parameters."""
