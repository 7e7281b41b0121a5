"""The forward model, its sensitivities, and the mixed model of the residuals."""
