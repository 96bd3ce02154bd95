(* ---- Rates: V falls at least as fast as exp (- 2 a t), in discrete time as r^(2 t); a, or r, is p / q ---- *)

Definition between (n : nat) (P now : list (list Z)) (N M : Z) : bool :=
  (0 <? N)%Z && nonneg n (times N (bilinear P now now) ++ times (-1) (squares now)) &&
  nonneg n (times M (squares now) ++ times (-1) (bilinear P now now)).
Definition decays_in_time (n : nat) (P now next : list (list Z)) (S : list term) (p q N M : Z) : bool :=
  weights S && (0 <? q)%Z && between n P now N M &&
  nonneg n (times (- q) (bilinear P now next ++ bilinear P next now) ++ times (-2 * p) (bilinear P now now)
            ++ times (- q) S).
Definition decays_by_steps (n : nat) (P now next : list (list Z)) (S : list term) (p q N M : Z) : bool :=
  weights S && (0 <? q)%Z && between n P now N M &&
  nonneg n (times (p * p) (bilinear P now now) ++ times (- (q * q)) (bilinear P next next) ++ times (- (q * q)) S).

Lemma between_sound : forall n P now N M z, between n P now N M = true -> length z = n ->
  0 < IZR N /\ value (squares now) z <= IZR N * value (bilinear P now now) z /\
  value (bilinear P now now) z <= IZR M * value (squares now) z.
Proof.
  intros n P now N M z H len; unfold between in H; rewrite !andb_true_iff, Z.ltb_lt in H; destruct H as [[pos A] B].
  pose proof (nonneg_sound n _ z A len) as C; pose proof (nonneg_sound n _ z B len) as D.
  rewrite !value_app, !value_times in C, D; apply IZR_lt in pos; split; [exact pos|split; lra].
Qed.

Theorem in_time_at_rate : forall n P now next S p q N M (z : R -> list R),
  decays_in_time n P now next S p q N M = true ->
  (forall t, length (z t) = n) -> flows z now next -> (forall t, 0 < t -> products_hold S (z t)) ->
  forall s t, 0 < s -> s <= t ->
  value (squares now) (z t) <= IZR (N * M) * exp (- (2 * (IZR p / IZR q) * (t - s))) * value (squares now) (z s).
Proof.
  intros n P now next S p q N M z test len F class s t Hs st.
  unfold decays_in_time in test; rewrite !andb_true_iff, Z.ltb_lt in test; destruct test as [[[W pos] B] falls].
  apply IZR_lt in pos; set (a := IZR p / IZR q).
  set (v := fun t => value (bilinear P now now) (z t)).
  set (v' := fun t => value (bilinear P now next) (z t) + value (bilinear P next now) (z t)).
  assert (slow : forall t, 0 < t -> v' t + 2 * a * v t <= 0).
  { intros u Hu; pose proof (nonneg_sound n _ (z u) falls (len u)) as L.
    rewrite !value_app, !value_times, !value_app, mult_IZR, opp_IZR in L; fold (v u) in L; fold (v' u) in L.
    pose proof (class_nonneg S (z u) W (class u Hu)).
    assert (E : IZR q * (v' u + 2 * a * v u) = IZR q * v' u + 2 * IZR p * v u) by (unfold a; field; lra).
    apply (Rmult_le_reg_l (IZR q)); [exact pos|]; rewrite E; simpl in L; nra. }
  assert (D : forall u, 0 < u -> derivable_pt_lim (fun u => v u * exp (2 * a * u)) u
      (v' u * exp (2 * a * u) + v u * (2 * a * exp (2 * a * u)))).
  { intros u Hu; apply (derivable_pt_lim_mult v (fun u => exp (2 * a * u))); [now apply flow_bilinear|].
    replace (2 * a * exp (2 * a * u)) with (exp (2 * a * u) * (2 * a * 1)) by ring.
    apply (derivable_pt_lim_comp (fun u => 2 * a * u) exp); [|apply derivable_pt_lim_exp].
    apply (derivable_pt_lim_scal id); apply derivable_pt_lim_id. }
  assert (K : v t * exp (2 * a * t) <= v s * exp (2 * a * s)).
  { apply (nonincreasing _ _ D); [|exact Hs|exact st]; intros u Hu.
    pose proof (slow u Hu); pose proof (exp_pos (2 * a * u)); nra. }
  destruct (between_sound n P now N M (z t) B (len t)) as [Npos [T _]].
  destruct (between_sound n P now N M (z s) B (len s)) as [_ [_ U]].
  fold (v t) in T; fold (v s) in U.
  replace (- (2 * a * (t - s))) with (2 * a * s + - (2 * a * t)) by ring; rewrite exp_plus, exp_Ropp.
  pose proof (exp_pos (2 * a * t)) as Et; pose proof (exp_pos (2 * a * s)) as Es.
  apply (Rmult_le_reg_r (exp (2 * a * t))); [exact Et|].
  replace (IZR (N * M) * (exp (2 * a * s) * / exp (2 * a * t)) * value (squares now) (z s) * exp (2 * a * t))
    with (IZR N * (exp (2 * a * s) * (IZR M * value (squares now) (z s)))) by (rewrite mult_IZR; field; lra).
  apply Rle_trans with (IZR N * v t * exp (2 * a * t)); [apply Rmult_le_compat_r; lra|].
  rewrite Rmult_assoc; apply Rmult_le_compat_l; [lra|]; apply Rle_trans with (1 := K).
  rewrite Rmult_comm; apply Rmult_le_compat_l; lra.
Qed.

Theorem by_steps_at_rate : forall n P now next S p q N M (z : nat -> list R),
  decays_by_steps n P now next S p q N M = true ->
  (forall t, length (z t) = n) -> (forall t, at_ now (z (Datatypes.S t)) = at_ next (z t)) ->
  (forall t, products_hold S (z t)) ->
  forall k t, value (squares now) (z (k + t)%nat) <= IZR (N * M) * (IZR p / IZR q) ^ (2 * k) * value (squares now) (z t).
Proof.
  intros n P now next S p q N M z test len step class k t.
  unfold decays_by_steps in test; rewrite !andb_true_iff, Z.ltb_lt in test; destruct test as [[[W pos] B] falls].
  apply IZR_lt in pos; set (r := IZR p / IZR q).
  set (v := fun t => value (bilinear P now now) (z t)).
  assert (next_v : forall u, v (Datatypes.S u) <= r ^ 2 * v u).
  { intro u; pose proof (nonneg_sound n _ (z u) falls (len u)) as L.
    rewrite !value_app, !value_times, opp_IZR, !mult_IZR in L; fold (v u) in L.
    assert (E : value (bilinear P next next) (z u) = v (Datatypes.S u)).
    { unfold v; rewrite !value_bilinear, step; reflexivity. }
    rewrite E in L; pose proof (class_nonneg S (z u) W (class u)).
    assert (G : IZR q * IZR q * (r ^ 2 * v u) = IZR p * IZR p * v u) by (unfold r; field; lra).
    apply (Rmult_le_reg_l (IZR q * IZR q)); [nra|]; rewrite G; nra. }
  assert (K : v (k + t)%nat <= r ^ (2 * k) * v t).
  { induction k as [|k IH]; [simpl; lra|].
    replace (2 * Datatypes.S k)%nat with (2 + 2 * k)%nat by lia; rewrite pow_add.
    apply Rle_trans with (1 := next_v (k + t)%nat).
    rewrite Rmult_assoc; apply Rmult_le_compat_l; [apply pow2_ge_0|exact IH]. }
  destruct (between_sound n P now N M (z (k + t)%nat) B (len _)) as [Npos [T _]].
  destruct (between_sound n P now N M (z t) B (len t)) as [_ [_ U]].
  fold (v (k + t)%nat) in T; fold (v t) in U.
  assert (pr : 0 <= r ^ (2 * k)) by (rewrite pow_mult; apply pow_le, pow2_ge_0).
  rewrite mult_IZR; apply Rle_trans with (1 := T).
  replace (IZR N * IZR M * r ^ (2 * k) * value (squares now) (z t))
    with (IZR N * (r ^ (2 * k) * (IZR M * value (squares now) (z t)))) by ring.
  apply Rmult_le_compat_l; [lra|]; apply Rle_trans with (1 := K); now apply Rmult_le_compat_l.
Qed.
