"""The sections of a session's report, one a file.

A module that defines `SECTION`, a ReportSection, adds a section; another distribution adds one by
an entry point of the group `labrig.report_sections`. `interface` has the contract, `conformance`
checks it.
"""
