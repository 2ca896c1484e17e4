//! Contact and levitation model of a fingertip on an ultrasonic plate, its inversion and its fits.
