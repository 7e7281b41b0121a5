"""Curves of many images: what is measured, what is known of each, what a stopped batch keeps."""
