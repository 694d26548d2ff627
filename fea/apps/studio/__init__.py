"""`fea studio`: a rod that is changed in the browser and answers at once."""
