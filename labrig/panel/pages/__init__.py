"""The pages of the operator's panel, one a file with the routes that are its own.

A module that defines `PAGE`, a PanelPage, adds a page; another distribution adds one by an entry
point of the group `labrig.page_panels`. `interface` has the contract, `conformance` checks it.
"""
