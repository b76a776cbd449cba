//! JSON → Experiment.
