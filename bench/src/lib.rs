//! Library of the test bench controller.
