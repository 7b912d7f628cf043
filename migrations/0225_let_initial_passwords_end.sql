-- Until when a password is good that somebody else has set, for one sign-in at which its owner chooses another; absent: their own.
ALTER TABLE people ADD COLUMN password_initial_until INTEGER;
