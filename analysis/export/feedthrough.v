(* ---- A feedthrough: with y = sigma + D phi(sigma), psi(y) = phi(sigma) is in a sector, too ---- *)

Lemma sector_through : forall D l u phi psi, l <= u -> 0 < 1 + D * l -> 0 < 1 + D * u -> in_sector l u phi ->
  (forall s, psi (s + D * phi s) = phi s) -> (forall y, exists s, y = s + D * phi s) ->
  in_sector (l / (1 + D * l)) (u / (1 + D * u)) psi.
Proof.
  intros D l u phi psi lu Pl Pu S inverse onto; split.
  - pose proof (inverse 0) as E; rewrite (proj1 S), Rmult_0_r, Rplus_0_r in E; exact E.
  - intro y; destruct (onto y) as [s ->]; rewrite inverse.
    destruct (gain_of l u phi s (phi s) S lu eq_refl) as [d [B E]]; rewrite E; clear E inverse onto S.
    set (p := 1 + D * d); assert (P : 0 < p).
    { unfold p; destruct (Rle_or_lt 0 D); nra. }
    replace (s + D * (d * s)) with (p * s) by (unfold p; ring).
    assert (Q : 0 <= p * (s * s)) by (apply Rmult_le_pos; [lra|apply Rle_0_sqr]).
    assert (low : l / (1 + D * l) * p <= d).
    { apply (Rmult_le_reg_l (1 + D * l)); [exact Pl|].
      replace ((1 + D * l) * (l / (1 + D * l) * p)) with (l * p) by (field; lra); unfold p; lra. }
    assert (high : d <= u / (1 + D * u) * p).
    { apply (Rmult_le_reg_l (1 + D * u)); [exact Pu|].
      replace ((1 + D * u) * (u / (1 + D * u) * p)) with (u * p) by (field; lra); unfold p; lra. }
    pose proof (Rmult_le_compat_r _ _ _ Q low); pose proof (Rmult_le_compat_r _ _ _ Q high); lra.
Qed.
