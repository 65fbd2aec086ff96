"""What frame time depends on: experiments that vary one thing at a time, and what follows from them."""
