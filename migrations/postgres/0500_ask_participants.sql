-- Whoever takes part in a study agrees themselves: a guest at the station, somebody of the school signed in. Until then they are asked, and
-- `consented_at` is when that was; a program before this one took it for their consent.
ALTER TABLE study_participants ADD COLUMN agreed_at BIGINT; -- absent: asked, and not answered yet

-- Somebody of the school was said to have agreed by whoever runs the study: while it goes on, they are asked. A guest whose code was not
-- used has not agreed at a station.
UPDATE study_participants SET agreed_at = consented_at
WHERE NOT EXISTS (SELECT 1 FROM people p JOIN studies u ON u.id = study_participants.study_id
    WHERE p.id = study_participants.person_id AND p.role <> 'guest' AND u.closed_at IS NULL AND NOT u.generated)
  AND NOT EXISTS (SELECT 1 FROM people p JOIN sign_in_codes c ON c.person_id = p.id
    WHERE p.id = study_participants.person_id AND p.role = 'guest'
      AND study_participants.consented_at = study_participants.added_at);
