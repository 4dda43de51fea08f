"""Tables, tests, curves and pages, made from rows and manifests only."""
