"""Planning, tracking and learned models of Implicit Contact Diffuser; knows no task."""
