//! Operator dashboard and participant screen.
