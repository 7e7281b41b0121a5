"""What is not known of all data alike: columns of the base model with narrow priors."""
