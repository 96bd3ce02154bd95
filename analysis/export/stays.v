(* ---- A form that depends on time along a solution of d x' = A x: it falls from the beginning to the end of a step ---- *)

Fixpoint row_size (u : list Z) : Z := match u with a :: u' => (Z.abs a + row_size u')%Z | [] => 0%Z end.
Fixpoint size_of (M : triangle) : Z := match M with (a, v) :: M' => (Z.abs a + row_size v + size_of M')%Z | [] => 0%Z end.
Fixpoint diagonal (n : nat) (c : Z) : triangle := match n with O => [] | S k => (c, []) :: diagonal k c end.
Fixpoint lie (i : nat) (M : triangle) (A : list (list Z)) : triangle :=
  match M, A with
  | (a, v) :: M', r :: A' => madd (product 1 r (repeat 0%Z i ++ a :: v))
      (madd (product 1 (repeat 0%Z i ++ [1%Z]) (combine_forms v A')) (lie (S i) M' A'))
  | _, _ => []
  end.
Fixpoint polar (M : triangle) (z w : list R) : R :=
  match M, z, w with
  | (a, v) :: M', x :: z', y :: w' => 2 * IZR a * x * y + 2 * (y * dot v z' + x * dot v w') + polar M' z' w'
  | _, _, _ => 0
  end.

Lemma row_size_nonneg : forall u, 0 <= IZR (row_size u).
Proof. induction u as [|a u IH]; cbn [row_size]; [lra|]; rewrite plus_IZR, abs_IZR; pose proof (Rabs_pos (IZR a)); lra. Qed.
Lemma size_nonneg : forall M, 0 <= IZR (size_of M).
Proof.
  induction M as [|[a v] M IH]; cbn [size_of]; [lra|]; rewrite !plus_IZR, abs_IZR.
  pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); lra.
Qed.
Lemma beside_bound : forall v x z, Rabs (2 * x * dot v z) <= IZR (row_size v) * (x * x + norm2 z).
Proof.
  induction v as [|a v IH]; intros x [|y z]; cbn [dot row_size norm2].
  - rewrite Rmult_0_r, Rabs_R0; lra.
  - rewrite Rmult_0_r, Rabs_R0; lra.
  - rewrite Rmult_0_r, Rabs_R0, plus_IZR, abs_IZR; pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); nra.
  - replace (2 * x * (IZR a * y + dot v z)) with (IZR a * (2 * x * y) + 2 * x * dot v z) by ring.
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite plus_IZR, abs_IZR, Rabs_mult.
    specialize (IH x z); pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); pose proof (norm2_nonneg z).
    assert (Rabs (2 * x * y) <= x * x + y * y).
    { apply Rabs_le; pose proof (Rle_0_sqr (x - y)); pose proof (Rle_0_sqr (x + y)); unfold Rsqr in *; lra. }
    assert (Rabs (IZR a) * Rabs (2 * x * y) <= Rabs (IZR a) * (x * x + y * y)) by (apply Rmult_le_compat_l; lra).
    pose proof (Rmult_le_pos _ _ (Rabs_pos (IZR a)) (norm2_nonneg z)).
    pose proof (Rmult_le_pos _ _ (row_size_nonneg v) (Rle_0_sqr y)); unfold Rsqr in *; lra.
Qed.
Lemma size_bound : forall M z, Rabs (qf M z) <= IZR (size_of M) * norm2 z.
Proof.
  induction M as [|[a v] M IH]; intros [|x z]; cbn [qf size_of norm2]; try (rewrite Rabs_R0; lra).
  specialize (IH z); pose proof (beside_bound v x z) as B; rewrite !plus_IZR, abs_IZR.
  apply Rle_trans with (1 := Rabs_triang _ _).
  apply Rle_trans with (Rabs (IZR a * (x * x)) + Rabs (2 * x * dot v z) + Rabs (qf M z)).
  { apply Rplus_le_compat_r, Rabs_triang. }
  rewrite Rabs_mult, (Rabs_right (x * x)) by nra.
  pose proof (Rabs_pos (IZR a)); pose proof (row_size_nonneg v); pose proof (size_nonneg M); pose proof (norm2_nonneg z); nra.
Qed.
Lemma qf_diagonal : forall n c z, length z = n -> qf (diagonal n c) z = IZR c * norm2 z.
Proof.
  induction n as [|n IH]; intros c [|x z] L; try discriminate; cbn [diagonal qf norm2 dot]; [ring|].
  rewrite IH by (cbn in L; lia); ring.
Qed.

Lemma dot_pad : forall i u z, dot (repeat 0%Z i ++ u) z = dot u (skipn i z).
Proof.
  induction i as [|i IH]; intros u [|x z]; cbn [repeat app dot skipn]; try reflexivity; [symmetry; apply dot_nil|].
  rewrite IH; ring.
Qed.
Lemma skipn_tl : forall (T : Type) i (z : list T), skipn (S i) z = tl (skipn i z).
Proof. induction i as [|i IH]; intros [|x z]; try reflexivity; exact (IH z). Qed.
Lemma qf_lie : forall M i A z, qf (lie i M A) z = polar M (skipn i z) (at_ A z).
Proof.
  induction M as [|[a v] M IH]; intros i [|r A] z; cbn [lie at_ map]; try (cbn [qf polar]; destruct (skipn i z); reflexivity).
  rewrite !qf_add, !qf_product, !dot_pad, dot_combine, IH, skipn_tl.
  destruct (skipn i z) as [|x w]; cbn [polar dot tl].
  - fold (at_ A z); destruct M as [|[b q] M]; cbn [polar]; ring.
  - fold (at_ A z); ring.
Qed.
Lemma dot_part : forall c v w, dot v (map (fun y => y / c) w) = dot v w / c.
Proof. intros c; induction v as [|a v IH]; intros [|y w]; cbn [dot map]; try (unfold Rdiv; ring); rewrite IH; unfold Rdiv; ring. Qed.
Lemma polar_part : forall c M z w, polar M z (map (fun y => y / c) w) = polar M z w / c.
Proof.
  intros c; induction M as [|[a v] M IH]; intros [|x z] [|y w]; cbn [polar map]; try (unfold Rdiv; ring).
  rewrite IH, dot_part; unfold Rdiv; ring.
Qed.

(* What is told by components. *)
Lemma dot_flow : forall (f : nat -> R -> R) f' t v a m, (forall i, (a <= i < a + m)%nat -> derivable_pt_lim (f i) t (f' i)) ->
  derivable_pt_lim (fun t => dot v (map (fun i => f i t) (seq a m))) t (dot v (map f' (seq a m))).
Proof.
  intros f f' t; induction v as [|c v IH]; intros a [|m] D; cbn [dot seq map]; try apply derivable_pt_lim_const.
  apply (derivable_pt_lim_plus (fun t => IZR c * f a t) (fun t => dot v (map (fun i => f i t) (seq (S a) m)))).
  - apply (derivable_pt_lim_scal (f a)), D; lia.
  - apply IH; intros i I; apply D; lia.
Qed.
Lemma qf_flow : forall (f : nat -> R -> R) f' t M a m, (forall i, (a <= i < a + m)%nat -> derivable_pt_lim (f i) t (f' i)) ->
  derivable_pt_lim (fun t => qf M (map (fun i => f i t) (seq a m))) t
    (polar M (map (fun i => f i t) (seq a m)) (map f' (seq a m))).
Proof.
  intros f f' t; induction M as [|[c v] M IH]; intros a [|m] D; cbn [qf polar seq map]; try apply derivable_pt_lim_const.
  assert (Da : derivable_pt_lim (f a) t (f' a)) by (apply D; lia).
  assert (Dv := dot_flow f f' t v (S a) m ltac:(intros i I; apply D; lia)).
  set (g := fun t => dot v (map (fun i => f i t) (seq (S a) m))) in *.
  apply (derivable_same (fun t => (IZR c * (f a t * f a t) + 2 * (f a t * g t)) + qf M (map (fun i => f i t) (seq (S a) m))) _ t
    (IZR c * (f' a * f a t + f a t * f' a) + 2 * (f' a * g t + f a t * dot v (map f' (seq (S a) m)))
      + polar M (map (fun i => f i t) (seq (S a) m)) (map f' (seq (S a) m)))).
  - intro s; unfold g; ring.
  - unfold g; ring.
  - apply (derivable_pt_lim_plus (fun t => IZR c * (f a t * f a t) + 2 * (f a t * g t))
      (fun t => qf M (map (fun i => f i t) (seq (S a) m)))); [|apply IH; intros i I; apply D; lia].
    apply (derivable_pt_lim_plus (fun t => IZR c * (f a t * f a t)) (fun t => 2 * (f a t * g t))).
    + apply (derivable_pt_lim_scal (fun t => f a t * f a t)), (derivable_pt_lim_mult (f a) (f a)); assumption.
    + apply (derivable_pt_lim_scal (fun t => f a t * g t)), (derivable_pt_lim_mult (f a) g); assumption.
Qed.

(* V = sum_k s^k/k! Q_k, s = (t - a)/d, with Q_(k+1) = - A'Q_k - Q_k A, and less d w |x|^2 for the first: V' = - w |x|^2
   and a last term, where d x' = A x. *)
Fixpoint follow (m : nat) (A : list (list Z)) (Q : triangle) : list triangle :=
  match m with O => [Q] | S k => Q :: follow k A (mscale (-1) (lie 0 Q A)) end.
Fixpoint last_of (m : nat) (A : list (list Z)) (Q : triangle) : triangle :=
  match m with O => Q | S k => last_of k A (mscale (-1) (lie 0 Q A)) end.
Fixpoint over (Qs : list triangle) (k : nat) (s : R) (z : list R) : R :=
  match Qs with [] => 0 | Q :: r => / INR (fact k) * s ^ k * qf Q z + over r (S k) s z end.

Definition solves (n : nat) (d : Z) (A : list (list Z)) (f : nat -> R -> R) : Prop :=
  forall i t, (i < n)%nat -> derivable_pt_lim (f i) t (dot (nth i A []) (listed n (fun i => f i t)) / IZR d).
Definition at_once (n : nat) (f : nat -> R -> R) (t : R) : list R := listed n (fun i => f i t).

Lemma rows_by_place : forall c z A,
  map (fun i => dot (nth i A []) z / c) (seq 0 (length A)) = map (fun y => y / c) (at_ A z).
Proof.
  intros c z; induction A as [|row A IH]; [reflexivity|]; cbn [length seq map nth at_]; f_equal.
  rewrite <- seq_shift, map_map; exact IH.
Qed.
Lemma solution_form : forall n d A f M t, length A = n -> solves n d A f ->
  derivable_pt_lim (fun t => qf M (at_once n f t)) t (qf (lie 0 M A) (at_once n f t) / IZR d).
Proof.
  intros n d A f M t L S0; unfold at_once, listed.
  apply (derivable_same (fun t => qf M (map (fun i => f i t) (seq 0 n))) _ t
    (polar M (map (fun i => f i t) (seq 0 n)) (map (fun i => dot (nth i A []) (listed n (fun i => f i t)) / IZR d) (seq 0 n))));
    [reflexivity| |apply qf_flow; intros i I; apply S0; lia].
  rewrite qf_lie; cbn [skipn]; fold (listed n (fun i => f i t)); set (z := listed n (fun i => f i t)).
  rewrite <- polar_part, <- L; f_equal; apply rows_by_place.
Qed.

Lemma power_flow : forall k a d t, d <> 0 ->
  derivable_pt_lim (fun t => / INR (fact (S k)) * ((t - a) / d) ^ S k) t (/ INR (fact k) * ((t - a) / d) ^ k / d).
Proof.
  intros k a d t nz.
  assert (D : derivable_pt_lim (fun t => (t - a) / d) t (/ d)).
  { apply (derivable_same (fun t => / d * (t - a)) _ t (/ d * (1 - 0))); [intro; field; exact nz|ring|].
    apply (derivable_pt_lim_scal (fun t => t - a)), (derivable_pt_lim_minus id (fun _ => a));
      [apply derivable_pt_lim_id|apply derivable_pt_lim_const]. }
  apply (derivable_same (fun t => / INR (fact (S k)) * ((t - a) / d) ^ S k) _ t
    (/ INR (fact (S k)) * (INR (S k) * ((t - a) / d) ^ k * / d))); [reflexivity| |].
  - rewrite fact_simpl, mult_INR; field; repeat split; try exact nz; try apply INR_fact_neq_0; apply not_0_INR; lia.
  - apply (derivable_pt_lim_scal (fun t => ((t - a) / d) ^ S k)).
    apply (derivable_pt_lim_comp (fun t => (t - a) / d) (fun s => s ^ S k)); [exact D|].
    exact (derivable_pt_lim_pow ((t - a) / d) (S k)).
Qed.
Lemma follow_flow : forall n d A f a t, length A = n -> solves n d A f -> IZR d <> 0 -> forall m k Q,
  derivable_pt_lim (fun t => over (follow m A Q) (S k) ((t - a) / IZR d) (at_once n f t)) t
    ((/ INR (fact k) * ((t - a) / IZR d) ^ k * qf Q (at_once n f t)
      + / INR (fact (S k + m)) * ((t - a) / IZR d) ^ (S k + m) * qf (lie 0 (last_of m A Q) A) (at_once n f t)) / IZR d).
Proof.
  intros n d A f a t L S0 nz.
  assert (one : forall k Q, derivable_pt_lim (fun t => / INR (fact (S k)) * ((t - a) / IZR d) ^ S k * qf Q (at_once n f t)) t
    (/ INR (fact k) * ((t - a) / IZR d) ^ k / IZR d * qf Q (at_once n f t)
      + / INR (fact (S k)) * ((t - a) / IZR d) ^ S k * (qf (lie 0 Q A) (at_once n f t) / IZR d))).
  { intros k Q; apply (derivable_pt_lim_mult (fun t => / INR (fact (S k)) * ((t - a) / IZR d) ^ S k)
      (fun t => qf Q (at_once n f t))); [now apply power_flow|now apply solution_form]. }
  induction m as [|m IH]; intros k Q; cbn [follow last_of over].
  - rewrite Nat.add_0_r.
    apply (derivable_same (fun t => / INR (fact (S k)) * ((t - a) / IZR d) ^ S k * qf Q (at_once n f t)) _ t
      (/ INR (fact k) * ((t - a) / IZR d) ^ k / IZR d * qf Q (at_once n f t)
        + / INR (fact (S k)) * ((t - a) / IZR d) ^ S k * (qf (lie 0 Q A) (at_once n f t) / IZR d)));
      [intro; ring|unfold Rdiv; ring|apply one].
  - specialize (IH (S k) (mscale (-1) (lie 0 Q A))); rewrite qf_scale in IH.
    replace (S k + S m)%nat with (S (S k) + m)%nat by lia.
    eapply derivable_same; [| |apply (derivable_pt_lim_plus _ _ _ _ _ (one k Q) IH)]; [reflexivity|].
    unfold Rdiv; ring.
Qed.

(* One piece: Q before, Q' after, the step h = d p/q. *)
Fixpoint zfact (k : nat) : Z := match k with O => 1%Z | S j => (Z.of_nat (S j) * zfact j)%Z end.
Fixpoint ending (Qs : list triangle) (k : nat) (p q : Z) : triangle * Z :=
  match Qs with
  | [] => ([], 1%Z)
  | Q :: r => match r with
    | [] => (Q, 1%Z)
    | _ => let (E, g) := ending r (S k) p q in
      let h := (q * Z.of_nat (S k) * g)%Z in (madd (mscale h Q) (mscale p E), h)
    end
  end.
Definition terms (n m : nat) (d w : Z) (A : list (list Z)) (Q : triangle) : list triangle :=
  Q :: follow m A (madd (mscale (-1) (lie 0 Q A)) (diagonal n (- (d * w)))).
Definition piece_ok (n m : nat) (d w D : Z) (A : list (list Z)) (p q : Z) (Q after : triangle) : bool :=
  let first := madd (mscale (-1) (lie 0 Q A)) (diagonal n (- (d * w))) in
  (p ^ Z.of_nat (S m) * size_of (lie 0 (last_of m A first) A) <=? d * w * zfact (S m) * q ^ Z.of_nat (S m))%Z &&
  (let (E, g) := ending (terms n m d w A Q) 0 p q in
   size_of (madd E (madd (mscale (- g) after) (diagonal n (- (2 * D * g))))) <=? g * D)%Z.

Lemma zfact_fact : forall k, IZR (zfact k) = INR (fact k).
Proof. induction k as [|k IH]; [reflexivity|]; rewrite fact_simpl, mult_INR, <- IH; cbn [zfact]; now rewrite mult_IZR, <- INR_IZR_INZ. Qed.
Lemma ending_sound : forall p q s z, (0 < q)%Z -> s = IZR p / IZR q -> forall Qs k, Qs <> [] ->
  (0 < snd (ending Qs k p q))%Z /\
  over Qs k s z = / INR (fact k) * s ^ k * (qf (fst (ending Qs k p q)) z / IZR (snd (ending Qs k p q))).
Proof.
  intros p q s z qpos E; apply IZR_lt in qpos as Q0; induction Qs as [|Q r IH]; intros k some; [contradiction|].
  destruct r as [|Q1 r].
  - cbn [ending over fst snd]; split; [lia|field; apply INR_fact_neq_0].
  - destruct (IH (S k) ltac:(discriminate)) as [gpos V]; clear IH some; revert gpos V.
    change (ending (Q :: Q1 :: r) k p q) with (let (E, g) := ending (Q1 :: r) (S k) p q in
      let h := (q * Z.of_nat (S k) * g)%Z in (madd (mscale h Q) (mscale p E), h)).
    change (over (Q :: Q1 :: r) k s z) with (/ INR (fact k) * s ^ k * qf Q z + over (Q1 :: r) (S k) s z).
    destruct (ending (Q1 :: r) (S k) p q) as [F g]; cbn [fst snd]; intros gpos V; split; [nia|].
    rewrite V, qf_add, !qf_scale, !mult_IZR, <- INR_IZR_INZ, fact_simpl, mult_INR; apply IZR_lt in gpos.
    pose proof (INR_fact_neq_0 k); assert (INR (S k) <> 0) by (apply not_0_INR; lia).
    cbn [pow]; rewrite E; field; repeat split; lra.
Qed.

Lemma piece_falls : forall n m d w D A p q Q after f a, piece_ok n m d w D A p q Q after = true ->
  (0 < d)%Z -> (0 < q)%Z -> (0 < p)%Z -> length A = n -> solves n d A f ->
  qf after (at_once n f (a + IZR d * IZR p / IZR q)) + IZR D * norm2 (at_once n f (a + IZR d * IZR p / IZR q))
    <= qf Q (at_once n f a).
Proof.
  intros n m d w D A p q Q after f a test dpos qpos ppos L S0; unfold piece_ok in test.
  set (first := madd (mscale (-1) (lie 0 Q A)) (diagonal n (- (d * w)))) in test.
  apply andb_true_iff in test as [tail jump]; apply Z.leb_le in tail.
  assert (nz : IZR d <> 0) by (apply IZR_lt in dpos; lra).
  pose proof (IZR_lt _ _ dpos) as dp; pose proof (IZR_lt _ _ qpos) as qp; pose proof (IZR_lt _ _ ppos) as pp.
  set (h := IZR d * IZR p / IZR q); set (s := IZR p / IZR q).
  assert (hs : h / IZR d = s) by (unfold h, s; field; lra).
  assert (hpos : 0 < h) by (unfold h; apply Rdiv_lt_0_compat; nra).
  set (v := fun t => over (terms n m d w A Q) 0 ((t - a) / IZR d) (at_once n f t)).
  set (v' := fun t => - (IZR w * norm2 (at_once n f t)) + / INR (fact (S m)) * ((t - a) / IZR d) ^ S m
     * qf (lie 0 (last_of m A first) A) (at_once n f t) / IZR d).
  assert (Dv : forall t, derivable_pt_lim v t (v' t)).
  { intro t; unfold v, terms; cbn [over]; fold first.
    eapply derivable_same; [| |apply (derivable_pt_lim_plus (fun t => qf Q (at_once n f t)) _ _ _ _
      (solution_form n d A f Q t L S0) (follow_flow n d A f a t L S0 nz m 0 first))].
    - intro u; unfold plus_fct; cbn [fact pow INR]; field.
    - unfold v', first; rewrite qf_add, qf_scale, qf_diagonal by (unfold at_once; apply listed_length).
      rewrite opp_IZR, mult_IZR; cbn [Nat.add].
      set (T := / INR (fact (S m)) * ((t - a) / IZR d) ^ S m * qf _ (at_once n f t)).
      cbn [fact pow INR]; field; exact nz. }
  assert (down : forall t, a < t < a + h -> v' t <= 0).
  { intros t T; unfold v'; set (u := (t - a) / IZR d).
    assert (U : 0 <= u <= s).
    { unfold u; split; [apply Rmult_le_pos; [lra|left; now apply Rinv_0_lt_compat]|].
      rewrite <- hs; apply Rmult_le_compat_r; [left; now apply Rinv_0_lt_compat|lra]. }
    set (M := lie 0 (last_of m A first) A) in *; set (z := at_once n f t).
    pose proof (size_bound M z) as B; pose proof (norm2_nonneg z) as N; pose proof (size_nonneg M) as Z0.
    apply IZR_le in tail; rewrite !mult_IZR, <- !pow_IZR, zfact_fact in tail.
    pose proof (INR_fact_lt_0 (S m)) as F.
    assert (P : u ^ S m <= s ^ S m) by (apply pow_incr; exact U).
    assert (P0 : 0 <= u ^ S m) by (apply pow_le; lra).
    assert (R1 : s ^ S m * IZR (size_of M) <= IZR d * IZR w * INR (fact (S m))).
    { unfold s, Rdiv; rewrite Rpow_mult_distr, pow_inv.
      apply (Rmult_le_reg_r (IZR q ^ S m)); [apply pow_lt; exact qp|].
      replace (IZR p ^ S m * / IZR q ^ S m * IZR (size_of M) * IZR q ^ S m) with (IZR p ^ S m * IZR (size_of M))
        by (field; apply pow_nonzero; lra); lra. }
    assert (R2 : u ^ S m * qf M z <= IZR d * IZR w * INR (fact (S m)) * norm2 z).
    { apply Rle_trans with (u ^ S m * (IZR (size_of M) * norm2 z)).
      - apply Rmult_le_compat_l; [exact P0|]; apply Rle_trans with (2 := B); apply Rle_abs.
      - apply Rle_trans with (s ^ S m * IZR (size_of M) * norm2 z); [|apply Rmult_le_compat_r; assumption].
        rewrite <- Rmult_assoc; apply Rmult_le_compat_r; [exact N|]; apply Rmult_le_compat_r; assumption. }
    assert (R3 : / INR (fact (S m)) * u ^ S m * qf M z / IZR d <= IZR w * norm2 z); [|lra].
    apply (Rmult_le_reg_l (INR (fact (S m)) * IZR d)); [nra|].
    replace (INR (fact (S m)) * IZR d * (/ INR (fact (S m)) * u ^ S m * qf M z / IZR d)) with (u ^ S m * qf M z)
      by (field; lra); lra. }
  destruct (MVT_cor2 v v' a (a + h)) as [c [E C]]; [lra|intros; apply Dv|].
  pose proof (down c C) as K; assert (fall : v (a + h) <= v a) by nra.
  assert (V0 : v a = qf Q (at_once n f a)).
  { unfold v, terms; cbn [over]; replace ((a - a) / IZR d) with 0 by (field; exact nz).
    assert (Z0 : forall Qs k, over Qs (S k) 0 (at_once n f a) = 0).
    { induction Qs as [|M Qs IH]; intro k; cbn [over]; [reflexivity|]; rewrite IH, pow_i by lia; ring. }
    rewrite Z0; cbn [fact INR pow]; field. }
  destruct (ending_sound p q s (at_once n f (a + h)) qpos eq_refl (terms n m d w A Q) 0 ltac:(discriminate)) as [gpos V1].
  replace s with ((a + h - a) / IZR d) in V1 at 1 by (rewrite <- hs; f_equal; ring).
  fold (v (a + h)) in V1; destruct (ending (terms n m d w A Q) 0 p q) as [F g]; cbn [fst snd] in *.
  apply Z.leb_le, IZR_le in jump; apply IZR_lt in gpos; rewrite mult_IZR in jump.
  set (z := at_once n f (a + h)) in *.
  pose proof (size_bound (madd F (madd (mscale (- g) after) (diagonal n (- (2 * D * g))))) z) as B.
  rewrite !qf_add, qf_scale, qf_diagonal in B by (unfold z, at_once; apply listed_length).
  rewrite !opp_IZR, !mult_IZR in B; pose proof (norm2_nonneg z) as N.
  set (X := qf F z + _) in B.
  assert (B2 : - (IZR g * IZR D * norm2 z) <= X).
  { pose proof (Rle_abs (- X)) as K2; rewrite Rabs_Ropp in K2.
    pose proof (Rmult_le_compat_r (norm2 z) _ _ N jump); lra. }
  unfold X in B2; clear X B.
  assert (V2 : qf F z / IZR g <= qf Q (at_once n f a)).
  { cbn [fact INR pow] in V1; rewrite <- V0; apply Rle_trans with (2 := fall); rewrite V1; right; field; lra. }
  apply (Rmult_le_compat_l (IZR g)) in V2; [|lra]; replace (IZR g * (qf F z / IZR g)) with (qf F z) in V2 by (field; lra).
  apply (Rmult_le_reg_l (IZR g)); [exact gpos|]; lra.
Qed.
