//! Participant protocols: files, session state machine, crop and selection, verdicts.
