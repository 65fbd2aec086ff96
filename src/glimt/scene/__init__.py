"""What is drawn: plain objects that know no file, no array layout and no engine."""
